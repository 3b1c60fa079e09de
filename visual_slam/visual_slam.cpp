// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/visual_slam.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "common/angle.hpp"
#include "common/odometry_buffer.hpp"
#include "visual_slam/descriptor.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/landmark_recogniser.hpp"
#include "visual_slam/path_recorder.hpp"
#include "visual_slam/tracking_monitor.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;
using common::Pose2;

constexpr Nanoseconds kTwistInterval = 50'000'000;                              // over which the speed is taken
constexpr Nanoseconds kLoopEventInterval = 10 * common::kNanosecondsPerSecond;  // one event a visit, not one an image
constexpr double kRefillShare = 0.15;  // new features are looked for when so many of the wanted are missing

// A picture cannot stay the same to the last bit when the robot moves this far.
constexpr double kClearMove = 0.01;  // [m]
constexpr double kClearTurn = 0.01;  // [rad]

/// What is known of a landmark besides its place.
struct LandmarkRecord {
  int found = 0;
  int failed = 0;
  Nanoseconds last_seen = 0;
  std::uint8_t gray = 0;
  std::vector<std::uint8_t> descriptor;
};

/// A landmark being followed in a camera's pictures.
struct Track {
  LandmarkId landmark = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// A camera and what is being followed in it.
struct CameraTracks {
  Camera camera;
  std::vector<Track> tracks;
  std::optional<Nanoseconds> newest;
  std::shared_ptr<const std::vector<std::uint8_t>> pixels;  // of the newest image that differed from the one before
  Pose2 odometry_pose;                                      // at that image
};

std::uint8_t gray_at(const cv::Mat& picture, const Eigen::Vector2d& pixel) {
  return picture.at<unsigned char>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
}

}  // namespace

class VisualSlam::Implementation {
 public:
  Implementation(const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras)
      : options_(options),
        front_end_(make_front_end(options.front_end, cameras.size())),
        recogniser_(options.recognition),
        monitor_(options.tracking),
        filter_(options.filter, options.motion) {
    for (const auto& [name, calibration] : cameras) cameras_.push_back({Camera(name, calibration), {}, {}, {}, {}});
  }

  bool wants(const common::SensorMessage& message) const {
    if (const auto* image = std::get_if<common::Image>(&message)) return camera_index(image->sensor).has_value();
    return std::holds_alternative<common::WheelOdometry>(message);
  }

  common::ProcessResult process(const common::SensorMessage& message) {
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) odometry_.add(*odometry);
    if (const auto* image = std::get_if<common::Image>(&message)) return process_image(*image);
    return {};
  }

  void execute(const common::Command& command) {
    if (const auto* set = std::get_if<common::SetPose>(&command)) set_pose(*set);
    if (std::holds_alternative<common::Reset>(command)) reset();
    if (std::holds_alternative<common::Relocalise>(command)) {
      waiting_events_.push_back(event("refused", "a search of the whole map is not possible yet"));
    }
  }

  common::Trajectory2 final_trajectory() const { return path_.path(filter_); }

  std::vector<common::Landmark> landmarks() const {
    std::vector<common::Landmark> result;
    for (const auto& [id, record] : records_) {
      const std::optional<MapPoint> point = filter_.map_point(id);
      if (!point) continue;
      result.push_back({.id = id,
                        .position = point->position,
                        .covariance = point->covariance,
                        .gray = record.gray,
                        .observations = record.found,
                        .descriptor = record.descriptor});
    }
    return result;
  }

 private:
  std::optional<std::size_t> camera_index(const std::string& name) const {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (cameras_[i].camera.name == name) return i;
    }
    return std::nullopt;
  }

  /// Why an image cannot be used; empty when it can.
  std::optional<std::string> refuse(const common::Image& image) const {
    const std::optional<std::size_t> index = camera_index(image.sensor);
    if (!index) return fmt::format("image of camera '{}', which is not among the ones to use", image.sensor);
    const CameraTracks& from = cameras_[*index];
    const common::CameraCalibration& calibration = from.camera.calibration;
    if (image.width != calibration.width || image.height != calibration.height || !image.pixels ||
        image.pixels->size() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
      return fmt::format("image of {} x {} pixels, the calibration of {} says {} x {}", image.width, image.height,
                         image.sensor, calibration.width, calibration.height);
    }
    if (from.newest && image.stamp <= *from.newest) {
      return fmt::format("stamp {} of {} is not after the one before, {}", image.stamp, image.sensor, *from.newest);
    }
    if (newest_ && image.stamp < *newest_) {
      return fmt::format("stamp {} of {} is before the newest estimate, {}", image.stamp, image.sensor, *newest_);
    }
    if (!odometry_.pose_at(image.stamp)) {
      return fmt::format("no wheel odometry at stamp {}: the planar filter needs it", image.stamp);
    }
    return std::nullopt;
  }

  /// The pipeline: one image is one update at its own stamp.
  common::ProcessResult process_image(const common::Image& image) {
    if (std::optional<std::string> reason = refuse(image)) return {.estimate = {}, .rejected = std::move(reason)};
    CameraTracks& seeing = cameras_[*camera_index(image.sensor)];
    const cv::Mat picture(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data()));
    predict(image.stamp);
    seeing.newest = image.stamp;
    std::vector<common::Event> events;
    ImageEvidence evidence;
    if (is_frozen(seeing, image)) {
      judge(evidence, events);
      return {.estimate = estimate({}, {}, std::move(events)), .rejected = {}};
    }
    std::vector<Track> seen = follow(seeing, picture, evidence);
    recognise(seeing, picture, seen);
    const UpdateReport report = update(seeing, seen);
    account(seeing, seen, report, events);
    learn_looks(seeing, picture);
    keep_pose(image.stamp);
    evidence.inliers = report.inliers;
    evidence.textured = has_texture(seeing, evidence.inliers);
    judge(evidence, events);
    if (monitor_.map_may_grow()) add_features(seeing, picture);
    limit_map();
    return {.estimate = estimate(seen, report, std::move(events)), .rejected = {}};
  }

  void predict(Nanoseconds stamp) {
    const Pose2 now = *odometry_.pose_at(stamp);
    if (newest_) filter_.predict(odometry_pose_.inverse() * now);
    const std::optional<Pose2> before = odometry_.pose_at(stamp - kTwistInterval);
    twist_ = before ? Eigen::Vector3d(common::log_se2(before->inverse() * now) / common::to_seconds(kTwistInterval))
                    : Eigen::Vector3d::Zero();
    odometry_pose_ = now;
    newest_ = stamp;
  }

  /// Where a landmark should appear; empty when outside the image.
  std::optional<Eigen::Vector2d> predict_pixel(const Camera& camera, LandmarkId landmark) const {
    const std::optional<Prediction> prediction = filter_.predict_bearing(camera, landmark, {});
    if (!prediction) return std::nullopt;
    return camera.calibration.project(prediction->point.homogeneous());
  }

  /// The features of the camera's previous picture that are found again in this one.
  std::vector<Track> follow(CameraTracks& seeing, const cv::Mat& picture, ImageEvidence& evidence) {
    std::vector<ExpectedFeature> expected;
    for (const Track& track : seeing.tracks) {
      const std::optional<Eigen::Vector2d> pixel = predict_pixel(seeing.camera, track.landmark);
      if (pixel && seeing.camera.sees(*pixel, 0.0)) expected.push_back({track.landmark, track.pixel, *pixel});
    }
    evidence.expected = static_cast<int>(expected.size());
    std::vector<Track> seen;
    for (const FoundFeature& found : front_end_->follow(index_of(seeing), picture, expected)) {
      seen.push_back({found.id, found.pixel});
    }
    return seen;
  }

  std::size_t index_of(const CameraTracks& seeing) const { return static_cast<std::size_t>(&seeing - cameras_.data()); }

  /// Looks for landmarks of the map that should be in view and are not followed.
  void recognise(const CameraTracks& seeing, const cv::Mat& picture, std::vector<Track>& seen) {
    if (!options_.recognition.enabled) return;
    std::set<LandmarkId> followed;
    for (const Track& track : seen) followed.insert(track.landmark);
    std::vector<RecognitionCandidate> candidates;
    for (const auto& [id, record] : records_) {
      if (followed.contains(id) || !recogniser_.knows(id)) continue;
      if (std::optional<RecognitionCandidate> one = candidate(seeing.camera, id)) candidates.push_back(*one);
    }
    std::stable_sort(candidates.begin(), candidates.end(), [this](const auto& a, const auto& b) {
      return records_.at(a.id).found > records_.at(b.id).found;
    });
    const std::size_t limit = static_cast<std::size_t>(options_.recognition.candidates_per_image);
    if (candidates.size() > limit) candidates.resize(limit);
    for (const RecognitionCandidate& one : candidates) {
      if (const std::optional<FoundFeature> found = recogniser_.find(picture, one)) {
        seen.push_back({found->id, found->pixel});
      } else if (monitor_.map_may_grow()) {
        ++records_.at(one.id).failed;
      }
    }
  }

  std::optional<RecognitionCandidate> candidate(const Camera& camera, LandmarkId id) const {
    const std::optional<MapPoint> point = filter_.map_point(id);
    if (!point) return std::nullopt;
    RecognitionCandidate result;
    result.id = id;
    result.view = point->position - optical_centre(camera, filter_.pose());
    if (!recogniser_.comparable(id, result.view)) return std::nullopt;
    const std::optional<Eigen::Vector2d> rough = predict_pixel(camera, id);
    if (!rough || !camera.sees(*rough, options_.front_end.border)) return std::nullopt;
    const Pose2 row_shift = make_bearing(camera, *rough, options_.filter.pixel_sigma, twist_).row_shift;
    const std::optional<Prediction> prediction = filter_.predict_bearing(camera, id, row_shift);
    if (!prediction) return std::nullopt;
    const std::optional<Eigen::Vector2d> pixel = camera.calibration.project(prediction->point.homogeneous());
    if (!pixel || !camera.sees(*pixel, options_.front_end.border)) return std::nullopt;
    result.predicted = *pixel;
    const double sigma = camera.focal_length * std::sqrt(prediction->covariance.trace()) + options_.filter.pixel_sigma;
    result.radius = std::min(options_.recognition.search_sigma * sigma, options_.recognition.max_search_radius);
    return result;
  }

  UpdateReport update(const CameraTracks& seeing, const std::vector<Track>& seen) {
    std::vector<Measurement> measurements;
    for (const Track& track : seen) {
      measurements.push_back(
          {track.landmark, make_bearing(seeing.camera, track.pixel, options_.filter.pixel_sigma, twist_)});
    }
    return filter_.update(seeing.camera, measurements);
  }

  /// Keeps what was accepted, counts what failed, and lets go what is no use.
  void account(CameraTracks& seeing, const std::vector<Track>& seen, const UpdateReport& report,
               std::vector<common::Event>& events) {
    const std::vector<Track> before = std::exchange(seeing.tracks, {});
    std::vector<LandmarkId> accepted;
    int back_after_long = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      LandmarkRecord& record = records_.at(seen[i].landmark);
      if (!report.accepted[i]) {
        ++record.failed;
        continue;
      }
      if (common::to_seconds(*newest_ - record.last_seen) > options_.recognition.loop_absence) ++back_after_long;
      ++record.found;
      record.last_seen = *newest_;
      accepted.push_back(seen[i].landmark);
      seeing.tracks.push_back(seen[i]);
    }
    if (back_after_long >= options_.recognition.loop_landmarks &&
        (!last_loop_ || *newest_ - *last_loop_ > kLoopEventInterval)) {
      last_loop_ = *newest_;
      events.push_back(event("loop_closed", fmt::format("{} landmarks recognised after more than {} s", back_after_long,
                                                        options_.recognition.loop_absence)));
    }
    std::set<LandmarkId> useless;
    for (const LandmarkId id : filter_.convert(seeing.camera, accepted)) useless.insert(id);
    for (const Track& track : before) {
      if (!filter_.is_cartesian(track.landmark) && records_.at(track.landmark).last_seen != *newest_) {
        useless.insert(track.landmark);
      }
    }
    for (const auto& [id, record] : records_) {
      if (record.failed > record.found + options_.map.max_failures) useless.insert(id);
    }
    drop({useless.begin(), useless.end()});
  }

  void drop(const std::vector<LandmarkId>& landmarks) {
    filter_.remove(landmarks);
    forget(landmarks);
  }

  /// Everything about landmarks that are no longer in the filter.
  void forget(const std::vector<LandmarkId>& landmarks) {
    for (const LandmarkId id : landmarks) {
      records_.erase(id);
      recogniser_.forget(id);
      for (CameraTracks& camera : cameras_) {
        std::erase_if(camera.tracks, [id](const Track& track) { return track.landmark == id; });
      }
    }
  }

  /// Whether the image shows enough that could be followed.
  bool has_texture(const CameraTracks& seeing, int inliers) {
    const int enough = options_.tracking.min_inliers;
    return inliers >= enough ||
           static_cast<int>(front_end_->detect(index_of(seeing), {}, enough, cv::Mat()).size()) >= enough;
  }

  /// Whether the very same picture came again though the wheels turned: a stuck camera, whose picture says nothing. (To
  /// the filter it would look like a world without depth.)
  bool is_frozen(CameraTracks& seeing, const common::Image& image) const {
    const bool same = seeing.pixels && *seeing.pixels == *image.pixels;
    const Pose2 driven = seeing.odometry_pose.inverse() * odometry_pose_;
    if (same && (driven.translation().norm() > kClearMove || std::abs(driven.theta) > kClearTurn)) return true;
    if (!same) {
      seeing.pixels = image.pixels;
      seeing.odometry_pose = odometry_pose_;
    }
    return false;
  }

  /// Whether the camera still knows where it is.
  void judge(const ImageEvidence& evidence, std::vector<common::Event>& events) {
    const common::TrackingState before = monitor_.state();
    const common::TrackingState now = monitor_.update(*newest_, evidence);
    const std::string figures = fmt::format("{} features accepted of {} expected", evidence.inliers, evidence.expected);
    if (now == common::TrackingState::kLost && before != now) events.push_back(event("lost", figures));
    if (before == common::TrackingState::kLost && now == common::TrackingState::kTracking) {
      events.push_back(event("relocalised", figures));
    }
  }

  void learn_looks(const CameraTracks& seeing, const cv::Mat& picture) {
    std::vector<Eigen::Vector2d> pixels;
    std::vector<LandmarkRecord*> undescribed;
    for (const Track& track : seeing.tracks) {
      const std::optional<MapPoint> point = filter_.map_point(track.landmark);
      if (!point) continue;
      recogniser_.remember(track.landmark, picture, track.pixel,
                           point->position - optical_centre(seeing.camera, filter_.pose()));
      LandmarkRecord& record = records_.at(track.landmark);
      if (record.descriptor.empty()) {
        pixels.push_back(track.pixel);
        undescribed.push_back(&record);
      }
    }
    std::vector<std::vector<std::uint8_t>> descriptors = describe(picture, pixels);
    for (std::size_t i = 0; i < undescribed.size(); ++i) undescribed[i]->descriptor = std::move(descriptors[i]);
  }

  void keep_pose(Nanoseconds stamp) {
    const Pose2 since = last_keyframe_ ? last_keyframe_->inverse() * odometry_pose_ : Pose2{};
    if (!last_keyframe_ || since.translation().norm() > options_.map.keyframe_distance ||
        std::abs(since.theta) > common::to_radians(options_.map.keyframe_turn)) {
      filter_.add_keyframe(stamp, options_.map.max_keyframes);
      last_keyframe_ = odometry_pose_;
    }
  }

  void add_features(CameraTracks& seeing, const cv::Mat& picture) {
    const int missing = options_.front_end.features_per_image - static_cast<int>(seeing.tracks.size());
    if (missing < kRefillShare * options_.front_end.features_per_image) return;
    std::vector<Eigen::Vector2d> taken;
    for (const Track& track : seeing.tracks) taken.push_back(track.pixel);
    for (const Eigen::Vector2d& pixel : front_end_->detect(index_of(seeing), taken, missing, cv::Mat())) {
      const LandmarkId id = next_landmark_++;
      filter_.add_landmark(id, seeing.camera, make_bearing(seeing.camera, pixel, options_.filter.pixel_sigma, twist_),
                           *newest_);
      records_.emplace(
          id, LandmarkRecord{
                  .found = 1, .failed = 0, .last_seen = *newest_, .gray = gray_at(picture, pixel), .descriptor = {}});
      seeing.tracks.push_back({id, pixel});
    }
  }

  /// Over the limit the landmarks found least often go first, of those the longest unseen; never one in view.
  void limit_map() {
    const std::size_t limit = static_cast<std::size_t>(options_.map.max_landmarks);
    if (records_.size() <= limit) return;
    std::set<LandmarkId> followed;
    for (const CameraTracks& camera : cameras_) {
      for (const Track& track : camera.tracks) followed.insert(track.landmark);
    }
    std::vector<std::tuple<int, Nanoseconds, LandmarkId>> idle;
    for (const auto& [id, record] : records_) {
      if (!followed.contains(id)) idle.emplace_back(record.found, record.last_seen, id);
    }
    std::sort(idle.begin(), idle.end());
    std::vector<LandmarkId> surplus;
    for (std::size_t i = 0; i < idle.size() && records_.size() - surplus.size() > limit; ++i) {
      surplus.push_back(std::get<2>(idle[i]));
    }
    drop(surplus);
  }

  common::Event event(std::string kind, std::string detail) const {
    return {.stamp = newest_.value_or(0), .module = "visual", .kind = std::move(kind), .detail = std::move(detail)};
  }

  common::PoseEstimate estimate(const std::vector<Track>& seen, const UpdateReport& report,
                                std::vector<common::Event> events) {
    common::PoseEstimate result;
    result.stamp = *newest_;
    result.source = common::PoseSource::kVisual;
    result.map_epoch = epoch_;
    result.pose = filter_.pose();
    result.covariance = filter_.pose_covariance();
    result.state = monitor_.state();
    result.health.tracked_features = static_cast<int>(seen.size());
    result.health.inliers = report.inliers;
    if (report.inliers > 0) result.health.innovation = report.mean_nis;
    for (common::Event& waiting : waiting_events_) {
      waiting.stamp = *newest_;
      events.push_back(std::move(waiting));
    }
    waiting_events_.clear();
    result.events = std::move(events);
    path_.add(*newest_, odometry_pose_, result.pose);
    return result;
  }

  void set_pose(const common::SetPose& command) {
    path_.start_segment();
    forget(filter_.set_pose(command.pose, command.covariance));
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    monitor_.pose_was_set();
  }

  void reset() {
    path_.freeze(filter_);
    filter_ = Ekf(options_.filter, options_.motion);
    records_.clear();
    recogniser_.clear();
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    last_loop_.reset();
    monitor_ = TrackingMonitor(options_.tracking);
    ++epoch_;
    waiting_events_.push_back(event("map_reset", fmt::format("epoch {} begins", epoch_)));
  }

  VisualSlamOptions options_;
  std::vector<CameraTracks> cameras_;  // fixed once built: the filter keeps pointers to the cameras
  std::unique_ptr<FrontEnd> front_end_;
  LandmarkRecogniser recogniser_;
  TrackingMonitor monitor_;
  Ekf filter_;
  PathRecorder path_;
  common::OdometryBuffer odometry_;
  std::map<LandmarkId, LandmarkRecord> records_;  // of all landmarks in the filter
  LandmarkId next_landmark_ = 1;
  std::uint32_t epoch_ = 0;
  std::optional<Nanoseconds> newest_;  // stamp of the newest estimate
  Pose2 odometry_pose_;                // T_odom_base there
  Eigen::Vector3d twist_ = Eigen::Vector3d::Zero();
  std::optional<Pose2> last_keyframe_;  // by the odometry
  std::optional<Nanoseconds> last_loop_;
  std::vector<common::Event> waiting_events_;
};

common::Result<std::unique_ptr<VisualSlam>> VisualSlam::create(
    const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras, std::uint64_t,
    int threads) {
  if (cameras.empty()) return common::invalid_input("visual SLAM: no camera");
  for (const auto& [name, calibration] : cameras) {
    if (calibration.width <= 0 || calibration.height <= 0 || !(calibration.fx > 0.0) || !(calibration.fy > 0.0)) {
      return common::invalid_input(
          fmt::format("visual SLAM: camera '{}' has size {} x {} px and focal lengths {}, {} px; all must be above 0",
                      name, calibration.width, calibration.height, calibration.fx, calibration.fy));
    }
  }
  cv::setNumThreads(std::max(1, threads));
  return std::unique_ptr<VisualSlam>(new VisualSlam(std::make_unique<Implementation>(options, cameras)));
}

VisualSlam::VisualSlam(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
VisualSlam::~VisualSlam() = default;

bool VisualSlam::wants(const common::SensorMessage& message) const { return implementation_->wants(message); }
common::ProcessResult VisualSlam::process(const common::SensorMessage& message) {
  return implementation_->process(message);
}
void VisualSlam::execute(const common::Command& command) { implementation_->execute(command); }
common::Trajectory2 VisualSlam::final_trajectory() const { return implementation_->final_trajectory(); }
std::vector<common::Landmark> VisualSlam::landmarks() const { return implementation_->landmarks(); }

}  // namespace slamfuse::visual_slam
