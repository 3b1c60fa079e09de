// SPDX-License-Identifier: BSD-3-Clause
#include "service/input_numbering.hpp"

#include <utility>
#include <variant>

namespace slamfuse::service {

common::Result<std::optional<NumberedInput>> InputNumbering::next() {
  auto item = recording_.next();
  if (!item) return tl::unexpected(item.error());
  if (!*item) return std::optional<NumberedInput>();

  NumberedInput input;
  input.step.index = next_index_++;
  if (const auto* rejected = std::get_if<common::RejectedMessage>(&**item)) {
    input.step.stamp = rejected->stamp;
    input.step.rejected = *rejected;
  } else {
    auto& message = std::get<common::SensorMessage>(**item);
    input.step.stamp = common::stamp_of(message);
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
      input.step.odometry = *odometry;
      T_odom_base_ = odometry->pose;
    }
    input.message =
        std::make_shared<const NumberedMessage>(NumberedMessage{input.step.index, std::move(message), T_odom_base_});
  }
  input.step.T_odom_base = T_odom_base_;
  return std::optional<NumberedInput>(std::move(input));
}

}  // namespace slamfuse::service
