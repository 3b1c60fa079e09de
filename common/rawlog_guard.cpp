// SPDX-License-Identifier: BSD-3-Clause
#include "common/rawlog_guard.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace slamfuse::common {
namespace {

/// A class in whatever namespace: MRPT takes old names without, too.
bool is_class(std::string_view text, std::string_view name) { return text.substr(text.rfind(':') + 1) == name; }

bool is_text(std::string_view bytes) {
  return std::ranges::all_of(bytes, [](unsigned char c) { return c > ' ' && c < 0x7f; });
}

std::uint32_t number_in(std::string_view bytes) {
  std::uint32_t number = 0;
  std::memcpy(&number, bytes.data(), sizeof(number));
  return number;
}
constexpr std::size_t kNumber = sizeof(std::uint32_t);

}  // namespace

std::string RawlogGuard::flaw_of(std::string_view piece) {
  std::string flaw = flaw_of_frame(piece);
  if (flaw.empty()) flaw = flaw_of_actions(piece);
  if (flaw.empty()) flaw = flaw_of_movement(piece);
  return flaw;
}

std::string RawlogGuard::flaw_of_frame(std::string_view piece) {
  constexpr std::uint32_t kMostInFrame = 10'000;
  if (is_class(piece, "CSensoryFrame")) {
    frame_begun_ = true;
  } else if (frame_begun_ && piece.size() == kNumber) {
    frame_begun_ = false;
    if (number_in(piece) > kMostInFrame) {
      return "a frame says it holds " + std::to_string(number_in(piece)) + " observations";
    }
  }
  return {};
}

std::string RawlogGuard::flaw_of_actions(std::string_view piece) {
  constexpr std::uint32_t kMostActions = 100;
  constexpr unsigned char kEndOfObject = 0x88;
  constexpr unsigned char kNamed = 0x80;  // this bit marks the length of a name
  const bool is_byte = piece.size() == 1;
  const auto byte = static_cast<unsigned char>(piece.front());
  const bool is_action = is_class(piece, "CActionRobotMovement2D") || is_class(piece, "CActionRobotMovement3D");
  switch (actions_) {
    case Actions::kNone:
      if (is_class(piece, "CActionCollection")) actions_ = Actions::kNumber;
      break;
    case Actions::kNumber:
      if (piece.size() != kNumber) break;
      if (number_in(piece) > kMostActions) {
        return "a collection says it holds " + std::to_string(number_in(piece)) + " actions";
      }
      actions_ = number_in(piece) > 0 ? Actions::kFirstLength : Actions::kNone;
      several_ = number_in(piece) > 1;
      break;
    case Actions::kFirstLength:
      // Before 2008 objects had no mark at their end: where the second one begins cannot be seen.
      if ((byte & kNamed) == 0 && several_) return "a collection of before 2008 holds several actions";
      actions_ = Actions::kFirstName;
      break;
    case Actions::kFirstName:
      if (piece.size() == 2) break;  // before 2008 the length had four bytes
      if (!is_action) return "a collection of actions holds something else";
      actions_ = Actions::kAny;
      break;
    case Actions::kLength:
      // Behind an object within an action comes a number or a second mark, which may look like a length.
      name_ = byte & static_cast<unsigned char>(~kNamed);
      actions_ = is_byte && (byte & kNamed) != 0 ? Actions::kName : Actions::kAny;
      break;
    case Actions::kName:
      actions_ = Actions::kAny;
      if (piece.size() == name_ && is_text(piece) && !is_action) return "a collection of actions holds something else";
      if (is_byte && (byte & kNamed) != 0) {  // the length before was a second mark
        name_ = byte & static_cast<unsigned char>(~kNamed);
        actions_ = Actions::kName;
      }
      break;
    case Actions::kAny:
      if (is_byte && byte == kEndOfObject) actions_ = Actions::kLength;
      break;
  }
  return {};
}

std::string RawlogGuard::flaw_of_movement(std::string_view piece) {
  constexpr std::uint32_t kMostParticles = 1'000'000;
  const bool byte = piece.size() == 1;
  if (is_class(piece, "CActionRobotMovement2D")) {
    movement_ = Movement::kVersion;
    return {};
  }
  switch (movement_) {
    case Movement::kNone:
      break;
    case Movement::kVersion:
      version_ = static_cast<unsigned char>(piece.front());
      movement_ = version_ < 2 ? Movement::kPdf : Movement::kMethod;
      break;
    case Movement::kMethod:
      movement_ = piece.size() == kNumber && number_in(piece) == 0 ? Movement::kOdometry : Movement::kPdf;
      break;
    case Movement::kPdf:
      if (byte) break;  // the length of the name
      movement_ = Movement::kNone;
      if (!piece.substr(piece.rfind(':') + 1).starts_with("CPosePDF")) return "a movement holds no pose";
      break;
    case Movement::kOdometry:
      if (!byte) movement_ = Movement::kPoseVersion;
      break;
    case Movement::kPoseVersion:  // the first one had numbers of 4 bytes, which cannot be told from the model's
      movement_ = piece.front() == 0 ? Movement::kNone : Movement::kModel;
      numbers_ = 0;
      break;
    case Movement::kModel: {
      if (piece.size() != kNumber) break;
      ++numbers_;
      const bool gaussian = numbers_ == 1 && number_in(piece) == 0;
      const bool particles = numbers_ == (version_ < 4 ? 7 : 8);
      if (gaussian || particles) movement_ = Movement::kNone;
      if (particles && number_in(piece) > kMostParticles) {
        return "a movement says it has " + std::to_string(number_in(piece)) + " particles";
      }
      break;
    }
  }
  return {};
}

}  // namespace slamfuse::common
