// SPDX-License-Identifier: BSD-3-Clause
// A robot over Fast DDS, set up as ROS 2's rmw_fastrtps does it: plays a recording to `serve` and writes down what
// `serve` publishes.
//
//     fast_dds_client RECORDING SECONDS RATE FOLDER
//
// Publishes scan, odom, camN/image_raw, camN/camera_info and tf_static. FOLDER/messages.txt: one line a message.
// FOLDER/played appears when all is sent; it ends when `serve` has gone. Domain: ROS_DOMAIN_ID, on loopback.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include "common/replay.hpp"
#include "foreign/messages.hpp"
#include "foreign/raw_type.hpp"

namespace {

namespace fs = std::filesystem;
using namespace eprosima::fastdds::dds;
using namespace slamfuse;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Kind {
  ReliabilityQosPolicyKind reliability = RELIABLE_RELIABILITY_QOS;
  DurabilityQosPolicyKind durability = VOLATILE_DURABILITY_QOS;
  int depth = 10;
};
constexpr Kind kLatched{RELIABLE_RELIABILITY_QOS, TRANSIENT_LOCAL_DURABILITY_QOS, 1};

DomainParticipant* join() {
  DomainParticipantQos qos;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = {"127.0.0.1"};
  udp->sendBufferSize = udp->receiveBufferSize = 4 << 20;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  const char* const id = std::getenv("ROS_DOMAIN_ID");
  return DomainParticipantFactory::get_instance()->create_participant(
      static_cast<std::uint32_t>(id == nullptr ? 0 : std::atoi(id)), qos);
}

class Robot {
 public:
  explicit Robot(const fs::path& folder)
      : participant_(join()),
        publisher_(participant_->create_publisher(PUBLISHER_QOS_DEFAULT)),
        subscriber_(participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT)),
        lines_(folder / "messages.txt") {}

  DataWriter* writer(const std::string& name, const std::string& type, const Kind& kind = {}) {
    DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.publish_mode().kind = ASYNCHRONOUS_PUBLISH_MODE;
    qos.reliability().kind = kind.reliability;
    qos.durability().kind = kind.durability;
    qos.history().depth = kind.depth;
    return publisher_->create_datawriter(topic(name, type), qos);
  }

  DataReader* listen(const std::string& name, const std::string& type, std::string (*read)(std::vector<char>&),
                     const Kind& kind = {}) {
    DataReaderQos qos = DATAREADER_QOS_DEFAULT;
    qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.reliability().kind = kind.reliability;
    qos.durability().kind = kind.durability;
    qos.history().depth = 100;
    listeners_.push_back(std::make_unique<Listener>(*this, read));
    return subscriber_->create_datareader(topic(name, type), qos, listeners_.back().get());
  }

  void note(const std::string& line) {
    const std::lock_guard lock(mutex_);
    lines_ << line << '\n' << std::flush;
  }

 private:
  class Listener : public DataReaderListener {
   public:
    Listener(Robot& robot, std::string (*read)(std::vector<char>&)) : robot_(robot), read_(read) {}
    void on_data_available(DataReader* reader) override {
      std::vector<char> message;
      SampleInfo info;
      while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
        if (info.valid_data) robot_.note(read_(message));
      }
    }

   private:
    Robot& robot_;
    std::string (*read_)(std::vector<char>&);
  };

  Topic* topic(const std::string& name, const std::string& type) {
    const TypeSupport support(new foreign::RawType(type));
    support.register_type(participant_);
    return participant_->create_topic("rt/" + name, type, TOPIC_QOS_DEFAULT);
  }

  DomainParticipant* participant_;
  Publisher* publisher_;
  Subscriber* subscriber_;
  std::mutex mutex_;
  std::ofstream lines_;
  std::vector<std::unique_ptr<Listener>> listeners_;
};

bool matched(DataWriter* writer) {
  PublicationMatchedStatus status;
  writer->get_publication_matched_status(status);
  return status.current_count > 0;
}

bool matched(DataReader* reader) {
  SubscriptionMatchedStatus status;
  reader->get_subscription_matched_status(status);
  return status.current_count > 0;
}

void send(DataWriter* writer, std::vector<char> message) { writer->write(&message); }

/// The writers of a recording's sensors.
class Drivers {
 public:
  Drivers(Robot& robot, const common::RecordingInfo& info)
      : info_(info),
        mountings_(robot.writer("tf_static", "tf2_msgs::msg::dds_::TFMessage_", kLatched)),
        scan_(robot.writer("scan", "sensor_msgs::msg::dds_::LaserScan_")),
        odometry_(robot.writer("odom", "nav_msgs::msg::dds_::Odometry_")) {
    for (const auto& [name, camera] : info.calibration.cameras) {
      images_[name] = robot.writer(name + "/image_raw", "sensor_msgs::msg::dds_::Image_");
      infos_[name] = robot.writer(name + "/camera_info", "sensor_msgs::msg::dds_::CameraInfo_");
    }
    ::send(mountings_, foreign::mountings_message(info.calibration));
  }

  bool heard() const {
    bool all = matched(scan_) && matched(odometry_);
    for (const auto& [name, writer] : images_) all = all && matched(writer);
    return all;
  }

  void send(const common::SensorMessage& message) {
    if (const auto* scan = std::get_if<common::LaserScan>(&message)) {
      ::send(scan_, foreign::scan_message(*scan, info_.calibration.lasers.at(scan->sensor)));
    } else if (const auto* image = std::get_if<common::Image>(&message)) {
      const auto& camera = info_.calibration.cameras.at(image->sensor);
      ::send(infos_.at(image->sensor), foreign::camera_info_message(image->sensor, image->stamp, camera));
      ::send(images_.at(image->sensor), foreign::image_message(*image));
    } else if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
      ::send(odometry_, foreign::odometry_message(*odometry));
    }
  }

 private:
  common::RecordingInfo info_;
  DataWriter* mountings_;
  DataWriter* scan_;
  DataWriter* odometry_;
  std::map<std::string, DataWriter*> images_;
  std::map<std::string, DataWriter*> infos_;
};

template <class Condition>
bool wait_for(const Condition& condition, std::chrono::seconds patience) {
  const auto deadline = Clock::now() + patience;
  while (!condition()) {
    if (Clock::now() > deadline) return false;
    std::this_thread::sleep_for(10ms);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const fs::path folder = argv[4];
  const double rate = std::atof(argv[3]);
  common::ReplayOptions options;
  options.to = std::atof(argv[2]);
  const auto recording = common::replay(*common::open_recording(argv[1]), options);
  if (!recording) return 3;
  Robot robot(folder);
  robot.listen("slamfuse/pose", "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_", foreign::read_pose);
  robot.listen("tf", "tf2_msgs::msg::dds_::TFMessage_", foreign::read_transform);
  DataReader* const status =
      robot.listen("slamfuse/status", "slamfuse_msgs::msg::dds_::FusionStatus_", foreign::read_status);
  robot.listen("slamfuse/landmarks", "sensor_msgs::msg::dds_::PointCloud2_", foreign::read_landmarks);
  Drivers drivers(robot, (*recording)->info());
  if (!wait_for([&] { return drivers.heard(); }, 30s)) return 4;
  std::this_thread::sleep_for(500ms);

  const auto start = Clock::now();
  std::optional<common::Nanoseconds> first;
  while (true) {
    const auto item = (*recording)->next();
    if (!item || !*item) break;
    const auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message == nullptr) continue;
    const common::Nanoseconds stamp = common::stamp_of(*message);
    if (!first) first = stamp;
    std::this_thread::sleep_until(
        start + std::chrono::nanoseconds(static_cast<std::int64_t>(static_cast<double>(stamp - *first) / rate)));
    drivers.send(*message);
  }
  // Late, as a Nav2 that starts when the map is there.
  robot.listen("map", "nav_msgs::msg::dds_::OccupancyGrid_", foreign::read_map, kLatched);
  std::this_thread::sleep_for(3s);
  std::ofstream(folder / "played") << '\n';
  return wait_for([&] { return !matched(status); }, 60s) ? 0 : 5;
}
