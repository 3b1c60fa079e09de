// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include <fastdds/dds/topic/TopicDataType.hpp>

namespace foreign {

/// A type of Fast DDS whose samples are serialised messages, std::vector<char>: what fastddsgen would make, without it.
class RawType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1024;  // where the history's memory starts; it grows
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& message = *static_cast<const std::vector<char>*>(data);
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(message.size());
    std::memcpy(payload->data, message.data(), message.size());
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    const auto* begin = reinterpret_cast<const char*>(payload->data);
    static_cast<std::vector<char>*>(data)->assign(begin, begin + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const std::vector<char>*>(data)->size()); };
  }
  void* createData() override { return new std::vector<char>; }
  void deleteData(void* data) override { delete static_cast<std::vector<char>*>(data); }
  bool getKey(void* /*data*/, eprosima::fastrtps::rtps::InstanceHandle_t* /*handle*/, bool /*force*/) override {
    return false;
  }
};

}  // namespace foreign
