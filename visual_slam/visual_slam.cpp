// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/visual_slam.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <span>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "common/angle.hpp"
#include "common/odometry_buffer.hpp"
#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/feature_selection.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/image_clock.hpp"
#include "visual_slam/image_sampler.hpp"
#include "visual_slam/landmark_book.hpp"
#include "visual_slam/loop_search.hpp"
#include "visual_slam/observation_log.hpp"
#include "visual_slam/path_recorder.hpp"
#include "visual_slam/place_search.hpp"
#include "visual_slam/tracking_monitor.hpp"
#include "visual_slam/trust_chain.hpp"
#include "visual_slam/turn_search.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;
using common::Pose2;
using common::Pose3;

constexpr Nanoseconds kTwistInterval = 50'000'000;                              // over which the speed is taken
constexpr Nanoseconds kLoopEventInterval = 10 * common::kNanosecondsPerSecond;  // one event a visit, not one an image
constexpr double kCarriedAway = 16.3;  // squared standard deviations, by which one pose in 1000 misses by chance
constexpr double kUnknown = 100.0;     // [m], [rad] standard deviation of a pose nothing is known of
constexpr double kRefillShare = 0.15;  // new features are looked for when so many of the wanted are missing

std::set<LandmarkId> numbers(const std::vector<Track>& tracks) {
  std::set<LandmarkId> result;
  for (const Track& track : tracks) result.insert(track.landmark);
  return result;
}

/// Whether the picture shows anything: at most half of it is black or white to the last step or two. Features at the
/// edges of what is saturated move with the light.
bool is_exposed(const cv::Mat& picture) {
  constexpr double kDark = 2.0, kBright = 253.0;  // [gray]
  cv::Mat inside;
  cv::inRange(picture, cv::Scalar(kDark), cv::Scalar(kBright), inside);
  return 2 * cv::countNonZero(inside) >= picture.rows * picture.cols;
}

}  // namespace

class VisualSlam::Implementation {
 public:
  Implementation(const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras,
                 std::uint64_t seed, FeatureSelection selection)
      : options_(options),
        selection_(std::move(selection)),
        front_end_(make_front_end(options.front_end, cameras.size())),
        turn_search_(options.turn_search, cameras.size()),
        book_(options),
        search_(options.relocalisation, seed),
        loop_search_(options.loop, options.relocalisation, seed),
        monitor_(options.tracking),
        observations_(options.map),
        trust_(options.tracking.min_inliers),
        filter_(options.filter, options.motion) {
    for (const auto& [name, calibration] : cameras) cameras_.emplace_back(Camera(name, calibration));
    for (const CameraTracks& seeing : cameras_)
      clocks_.emplace_back(options.image_clock, options.turn_search, seeing.camera);
  }

  bool wants(const common::SensorMessage& message) const {
    if (const auto* image = std::get_if<common::Image>(&message)) return camera_index(image->sensor).has_value();
    return has_odometry() && std::holds_alternative<common::WheelOdometry>(message);
  }

  common::ProcessResult process(const common::SensorMessage& message) {
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
      odometry_.add(*odometry);
      for (ImageClock& clock : clocks_) clock.add(*odometry);
    }
    if (const auto* image = std::get_if<common::Image>(&message)) return process_image(by_odometry_clock(*image));
    return {};
  }

  void execute(const common::Command& command) {
    if (const auto* set = std::get_if<common::SetPose>(&command)) set_pose(*set);
    if (std::holds_alternative<common::Reset>(command)) reset();
    if (std::holds_alternative<common::Relocalise>(command)) relocalise();
  }

  /// Whether a pose can be found in the whole map.
  bool can_search() const { return options_.relocalisation.enabled && filter_.is_planar(); }

  void load(const std::vector<common::Landmark>& map, MapUse use) {
    localising_ = false;
    if (newest_) reset();
    take_map(map, use);
  }

  common::Trajectory3 spatial_trajectory() const { return path_.path(filter_); }

  std::vector<common::Landmark> landmarks() const { return book_.landmarks(filter_); }

  std::vector<common::Keyframe> keyframes() const {
    const common::Trajectory3 path = spatial_trajectory();  // its stamps never step back
    std::vector<common::Keyframe> keyframes;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const Camera& camera = cameras_[i].camera;
      for (const KeptPicture& picture : observations_.pictures(i)) {
        const auto at = std::lower_bound(path.begin(), path.end(), picture.stamp,
                                         [](const auto& pose, Nanoseconds stamp) { return pose.stamp < stamp; });
        common::Pose3 T_map_camera;
        T_map_camera.translation = optical_centre(camera, at->pose, filter_.lever_scale());
        T_map_camera.rotation = at->pose.rotation * camera.calibration.T_base_camera.rotation;
        keyframes.push_back({camera.name, picture.stamp, T_map_camera, picture.observations});
      }
    }
    return keyframes;
  }

  std::vector<common::AnnotatedImage> sample_images() const { return sampler_.images(); }

 private:
  bool has_odometry() const { return options_.motion.model == MotionModelKind::kOdometry; }

  std::optional<std::size_t> camera_index(const std::string& name) const {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (cameras_[i].camera.name == name) return i;
    }
    return std::nullopt;
  }

  static bool has_size_of(const common::CameraCalibration& calibration, const common::Image& image) {
    return image.width == calibration.width && image.height == calibration.height && image.pixels &&
           image.pixels->size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  }

  /// The image with its stamp as its camera's clock is believed to be off the wheel odometry's. When that changes the
  /// map is of no use, as it was made with odometry of other times.
  common::Image by_odometry_clock(common::Image image) {
    const std::optional<std::size_t> index = camera_index(image.sensor);
    if (!index || !has_odometry() || !has_size_of(cameras_[*index].camera.calibration, image)) return image;
    ImageClock& clock = clocks_[*index];
    if (clock.watch(picture_of(image), image.stamp)) {
      waiting_events_.push_back(event(
          "clock_offset", fmt::format("stamps of {} are moved by {:+.1f} ms, where the turns in its pictures fit the "
                                      "wheel odometry's; the map begins anew",
                                      image.sensor, 1e3 * common::to_seconds(clock.correction()))));
      reset();
    }
    image.stamp += clock.correction();
    return image;
  }

  static cv::Mat picture_of(const common::Image& image) {
    return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data())};
  }

  void take_map(const std::vector<common::Landmark>& map, MapUse use) {
    localising_ = use == MapUse::kLocalise;
    for (const common::Landmark& landmark : map) {
      book_.restore(landmark);
      filter_.add_fixed_landmark(landmark.id, {landmark.position, landmark.covariance});
    }
    doubt_pose();
  }

  /// Why an image cannot be used; empty when it can.
  std::optional<std::string> refuse(const common::Image& image) const {
    const std::optional<std::size_t> index = camera_index(image.sensor);
    if (!index) return fmt::format("image of camera '{}', which is not among the ones to use", image.sensor);
    const CameraTracks& from = cameras_[*index];
    const common::CameraCalibration& calibration = from.camera.calibration;
    if (!has_size_of(calibration, image)) {
      return fmt::format("image of {} x {} pixels, the calibration of {} says {} x {}", image.width, image.height,
                         image.sensor, calibration.width, calibration.height);
    }
    if (from.newest && image.stamp <= *from.newest) {
      return fmt::format("stamp {} of {} is not after the one before, {}", image.stamp, image.sensor, *from.newest);
    }
    if (newest_ && image.stamp < *newest_) {
      return fmt::format("stamp {} of {} is before the newest estimate, {}", image.stamp, image.sensor, *newest_);
    }
    if (has_odometry() && !odometry_.pose_at(image.stamp)) {
      return fmt::format("no wheel odometry at stamp {}: the planar filter needs it", image.stamp);
    }
    return std::nullopt;
  }

  /// The pipeline: one image is one update at its own stamp.
  common::ProcessResult process_image(const common::Image& image) {
    if (std::optional<std::string> reason = refuse(image)) return {.estimate = {}, .rejected = std::move(reason)};
    CameraTracks& seeing = cameras_[*camera_index(image.sensor)];
    const cv::Mat picture = picture_of(image);
    predict(image.stamp);
    seeing.newest = image.stamp;
    std::vector<common::Event> events;
    ImageEvidence evidence;
    if (seeing.is_frozen(image, odometry_pose_)) {
      judge(evidence, events);
      return {.estimate = estimate({}, {}, std::move(events)), .rejected = {}};
    }
    const bool exposed = is_exposed(picture);
    std::vector<Track> seen = exposed ? follow(seeing, picture, evidence) : std::vector<Track>{};
    UpdateReport report;
    if (!has_odometry()) report = update(seeing, seen, report);
    const std::size_t followed = seen.size();
    if (exposed && !pose_doubted_) {
      const std::vector<Track> recognised =
          book_.recognise(filter_, seeing.camera, twist_, picture, numbers(seen), map_may_grow());
      seen.insert(seen.end(), recognised.begin(), recognised.end());
      const int missing = options_.front_end.features_per_image - static_cast<int>(seen.size());
      if ((map_may_grow() || placed_) && missing >= kRefillShare * options_.front_end.features_per_image) {
        const std::vector<Track> recalled = book_.recall(filter_, seeing.camera, twist_, picture, missing);
        seen.insert(seen.end(), recalled.begin(), recalled.end());
      }
    }
    report = update(seeing, seen, report);
    account(seeing, seen, report, events);
    if (!localising_) {
      book_.learn_looks(filter_, seeing.camera, picture, seeing.tracks);
      if (!pose_doubted_) keep_pose(image.stamp);
    }
    evidence.inliers = report.inliers;
    evidence.textured = exposed && has_texture(seeing, evidence.inliers);
    evidence.doubted = has_odometry() && doubts(seeing, report, events);
    judge(evidence, events);
    if (exposed) {
      search_map(seeing, picture);
      close_loop(seeing, picture, events);
    }
    const std::size_t known = seeing.tracks.size();
    if (exposed && !localising_ && map_may_grow()) add_features(seeing, picture);
    remember(seeing, image, seen, report, followed, known);
    if (!localising_) limit_map();
    return {.estimate = estimate(seen, report, std::move(events)), .rejected = {}};
  }

  void predict(Nanoseconds stamp) {
    if (has_odometry()) {
      predict_by_odometry(stamp);
    } else {
      if (newest_) filter_.predict({common::to_seconds(stamp - *newest_), {}});
      twist_ = *filter_.twist();
      odometry_pose_ = filter_.pose();
    }
    newest_ = stamp;
  }

  void predict_by_odometry(Nanoseconds stamp) {
    const Pose2 now = *odometry_.pose_at(stamp);
    if (newest_) filter_.predict({common::to_seconds(stamp - *newest_), odometry_pose_.inverse() * now});
    const std::optional<Pose2> before = odometry_.pose_at(stamp - kTwistInterval);
    twist_ =
        before ? BodyTwist(common::log_se2(before->inverse() * now) / common::to_seconds(kTwistInterval)) : BodyTwist();
    odometry_pose_ = now;
  }

  /// The features of the camera's previous picture that are found again in this one.
  std::vector<Track> follow(CameraTracks& seeing, const cv::Mat& picture, ImageEvidence& evidence) {
    std::vector<ExpectedFeature> expected;
    for (const Track& track : seeing.tracks) {
      const std::optional<Eigen::Vector2d> pixel = predict_pixel(filter_, seeing.camera, track.landmark);
      if (!pixel || !seeing.camera.sees(*pixel, 0.0)) continue;
      expected.push_back({track.landmark, track.pixel, *pixel});
      if (book_.was_found_again(track.landmark)) ++evidence.expected;
    }
    if (!has_odometry()) turn_predictions(seeing, picture, expected);
    std::vector<Track> seen;
    for (const FoundFeature& found : front_end_->follow(index_of(seeing), picture, expected)) {
      seen.push_back({found.id, found.pixel});
    }
    return seen;
  }

  /// Moves the predicted pixels to where a turn nobody told of has taken them.
  void turn_predictions(const CameraTracks& seeing, const cv::Mat& picture, std::vector<ExpectedFeature>& expected) {
    const double turn = turn_search_.find(index_of(seeing), seeing.camera, picture, expected);
    for (ExpectedFeature& feature : expected) {
      feature.predicted = turned_pixel(seeing.camera, feature.predicted, turn).value_or(feature.predicted);
    }
  }

  std::size_t index_of(const CameraTracks& seeing) const { return static_cast<std::size_t>(&seeing - cameras_.data()); }

  /// Corrects the filter by what was seen and is not in the report `so_far`; returns the report on all.
  UpdateReport update(const CameraTracks& seeing, const std::vector<Track>& seen, const UpdateReport& so_far) {
    const std::size_t done = so_far.accepted.size();
    std::vector<Measurement> measurements;
    for (const Track& track : std::span(seen).subspan(done)) {
      measurements.push_back(
          {track.landmark, make_bearing(seeing.camera, track.pixel, options_.filter.pixel_sigma, twist_)});
    }
    UpdateReport report = filter_.update(seeing.camera, measurements);
    if (!has_odometry()) twist_ = *filter_.twist();
    if (done == 0) return report;
    report.accepted.insert(report.accepted.begin(), so_far.accepted.begin(), so_far.accepted.end());
    const int inliers = report.inliers + so_far.inliers;
    report.mean_nis = (report.mean_nis * report.inliers + so_far.mean_nis * so_far.inliers) /
                      static_cast<double>(std::max(1, inliers));
    report.inliers = inliers;
    return report;
  }

  /// Keeps what was accepted, counts what failed, and lets go what is no use.
  void account(CameraTracks& seeing, const std::vector<Track>& seen, const UpdateReport& report,
               std::vector<common::Event>& events) {
    const std::vector<Track> before = std::exchange(seeing.tracks, {});
    std::vector<LandmarkId> accepted;
    int back_after_long = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!report.accepted[i]) {
        book_.fail(seen[i].landmark);
        continue;
      }
      if (book_.confirm(seen[i].landmark, *newest_) > options_.recognition.loop_absence) ++back_after_long;
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
      if (!filter_.is_cartesian(track.landmark) && !book_.seen_at(track.landmark, *newest_)) {
        useless.insert(track.landmark);
      }
    }
    for (const LandmarkId id : book_.failing()) useless.insert(id);
    drop({useless.begin(), useless.end()});
  }

  void drop(const std::vector<LandmarkId>& landmarks) {
    filter_.remove(landmarks);
    forget(landmarks);
  }

  /// Everything about landmarks that are no longer in the filter.
  void forget(const std::vector<LandmarkId>& landmarks) {
    for (const LandmarkId id : landmarks) {
      book_.forget(id);
      for (CameraTracks& camera : cameras_) {
        std::erase_if(camera.tracks, [id](const Track& track) { return track.landmark == id; });
      }
    }
  }

  /// Whether the estimate may be wrong though the features fit: the odometry contradicts the camera, or has done so and
  /// what is seen does not hang together with the map from before.
  bool doubts(const CameraTracks& seeing, const UpdateReport& report, std::vector<common::Event>& events) {
    if (report.wheels == SlipWatch::Verdict::kSlip) {
      events.push_back(event("wheel_slip", "the camera does not see what the wheel odometry says"));
    }
    if (report.wheels == SlipWatch::Verdict::kGrip) events.push_back(event("wheel_grip", "they agree again"));
    std::vector<LandmarkId> known;
    for (const Track& track : seeing.tracks) {
      if (filter_.is_cartesian(track.landmark)) known.push_back(track.landmark);
    }
    const bool doubtful = filter_.odometry_is_doubtful();
    if (doubtful) trust_.begin(book_.known(filter_));
    if (trust_.see(known) && !doubtful) trust_.end();
    return trust_.is_watching();
  }

  /// Whether the image shows enough that could be followed.
  bool has_texture(const CameraTracks& seeing, int inliers) {
    const int enough = options_.tracking.min_inliers;
    return inliers >= enough ||
           static_cast<int>(front_end_->detect(index_of(seeing), {}, enough, cv::Mat()).size()) >= enough;
  }

  /// Whether the camera still knows where it is.
  void judge(const ImageEvidence& evidence, std::vector<common::Event>& events) {
    const common::TrackingState before = monitor_.state();
    const common::TrackingState now = monitor_.update(*newest_, evidence);
    const std::string figures = fmt::format("{} features accepted of {} expected", evidence.inliers, evidence.expected);
    if (now == common::TrackingState::kLost && before != now) {
      events.push_back(event("lost", figures));
      placed_ = false;
    }
    if (before == common::TrackingState::kLost && now == common::TrackingState::kTracking) {
      events.push_back(event("relocalised", figures));
    }
  }

  /// Whether what is seen may be entered at the estimated pose. Without wheel odometry there is nothing that an image
  /// could contradict: features lost in a quick turn are replaced as long as the constant motion bridges the gap.
  bool map_may_grow() const {
    return has_odometry() ? monitor_.map_may_grow() : monitor_.state() != common::TrackingState::kLost;
  }

  /// Looks for the pose in the whole map while it is lost or what is seen contradicts it. What is found counts when the
  /// next image agrees: until then the state stays as it is.
  void search_map(const CameraTracks& seeing, const cv::Mat& picture) {
    if (map_may_grow() && monitor_.state() != common::TrackingState::kLost) {
      search_.end();
      return;
    }
    if (!can_search()) return;
    const std::vector<Eigen::Vector2d> features =
        front_end_->detect(index_of(seeing), {}, options_.relocalisation.features, cv::Mat());
    const Glimpse glimpse{*newest_, odometry_pose_, &seeing.camera, twist_, filter_.lever_scale()};
    if (const auto found = search_.look([this] { return landmarks(); }, glimpse, picture, features)) {
      if (pose_doubted_ || filter_.distance_to(found->pose, found->covariance) > kCarriedAway) {
        path_.restart_since(search_.since());
        place(found->pose, found->covariance);
      } else {
        filter_.correct_pose(found->pose, found->covariance);
      }
      pose_doubted_ = false;
      placed_ = true;
    }
  }

  /// Corrects the pose, and with it the map, by an old part of the map that is seen from where it should not be.
  void close_loop(const CameraTracks& seeing, const cv::Mat& picture, std::vector<common::Event>& events) {
    if (!can_search() || localising_) return;
    if (monitor_.state() != common::TrackingState::kTracking) {
      loop_search_.clear();
      return;
    }
    if (!loop_search_.is_due(*newest_)) return;
    const std::vector<Eigen::Vector2d> features =
        front_end_->detect(index_of(seeing), {}, options_.relocalisation.features, cv::Mat());
    const Glimpse glimpse{*newest_, odometry_pose_, &seeing.camera, twist_, filter_.lever_scale()};
    const auto old_map = [this](Nanoseconds stamp) { return book_.unseen_since(filter_, stamp); };
    const auto found = loop_search_.look(old_map, glimpse, filter_.pose(), picture, features);
    if (!found || filter_.distance_to(found->pose, found->covariance) < kCarriedAway) return;
    const Pose2 drift = filter_.pose().inverse() * found->pose;
    filter_.correct_pose(found->pose, found->covariance);
    loop_search_.clear();
    events.push_back(event(
        "loop_closed", fmt::format("{} old landmarks say the pose drifted by {:.2f} m and {:.1f} deg", found->landmarks,
                                   drift.translation().norm(), common::to_degrees(drift.theta))));
  }

  void relocalise() {
    if (!can_search()) {
      waiting_events_.push_back(
          event("refused", "the whole map cannot be searched for a free camera, or when it is switched off"));
      return;
    }
    doubt_pose();
    waiting_events_.push_back(event("lost", "the whole map is searched, as asked"));
  }

  /// Nothing is known of the pose: it is lost until found in the whole map, or set.
  void doubt_pose() {
    place(filter_.pose(), kUnknown * kUnknown * Eigen::Matrix3d::Identity());
    monitor_.lose();
    pose_doubted_ = true;
    search_.end();
  }

  void keep_pose(Nanoseconds stamp) {
    const Pose3 here = has_odometry() ? common::to_pose3(odometry_pose_) : filter_.spatial_pose();
    const Pose3 since = last_keyframe_ ? last_keyframe_->inverse() * here : Pose3{};
    if (!last_keyframe_ || since.translation.norm() > options_.map.keyframe_distance ||
        Eigen::AngleAxisd(since.rotation).angle() > common::to_radians(options_.map.keyframe_turn)) {
      filter_.add_keyframe(stamp, options_.map.max_keyframes);
      book_.archived().follow(filter_);
      last_keyframe_ = here;
    }
  }

  void add_features(CameraTracks& seeing, const cv::Mat& picture) {
    const int missing = options_.front_end.features_per_image - static_cast<int>(seeing.tracks.size());
    if (missing < kRefillShare * options_.front_end.features_per_image) return;
    std::vector<Eigen::Vector2d> taken;
    for (const Track& track : seeing.tracks) taken.push_back(track.pixel);
    const SelectedRegion region = selection_.select(picture);
    std::vector<Eigen::Vector2d> found = front_end_->detect(index_of(seeing), taken, missing, region.mask);
    if (const int few = options_.selection.least_features - static_cast<int>(taken.size() + found.size());
        few > 0 && !region.mask.empty()) {
      taken.insert(taken.end(), found.begin(), found.end());
      const std::vector<Eigen::Vector2d> more = front_end_->detect(index_of(seeing), taken, few, cv::Mat());
      found.insert(found.end(), more.begin(), more.end());
    }
    for (const Eigen::Vector2d& pixel : found) {
      const LandmarkId id = book_.enter(picture, pixel, *newest_, region.object_at(pixel));
      filter_.add_landmark(id, seeing.camera, make_bearing(seeing.camera, pixel, options_.filter.pixel_sigma, twist_),
                           *newest_);
      seeing.tracks.push_back({id, pixel});
    }
  }

  /// Keeps what the map's export and the report show of the image: the first `followed` of `seen` come from the image
  /// before, the others were recognised; the tracks from `known` on are new.
  void remember(const CameraTracks& seeing, const common::Image& image, const std::vector<Track>& seen,
                const UpdateReport& report, std::size_t followed, std::size_t known) {
    if (monitor_.state() == common::TrackingState::kTracking) {
      observations_.offer(index_of(seeing), image.stamp, odometry_pose_, seeing.tracks);
    }
    if (!sampler_.wants(image.sensor, image.stamp)) return;
    common::AnnotatedImage sample{image, monitor_.state(), {}};
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const common::FeatureOutcome good =
          i < followed ? common::FeatureOutcome::kFollowed : common::FeatureOutcome::kRecognised;
      sample.features.push_back({seen[i].pixel, report.accepted[i] ? good : common::FeatureOutcome::kRejected});
    }
    for (const Track& track : std::span(seeing.tracks).subspan(known)) {
      sample.features.push_back({track.pixel, common::FeatureOutcome::kNew});
    }
    sampler_.keep(std::move(sample));
  }

  void limit_map() {
    std::set<LandmarkId> followed;
    for (const CameraTracks& camera : cameras_) followed.merge(numbers(camera.tracks));
    const std::vector<LandmarkId> surplus = book_.surplus(followed);
    book_.archive(filter_, surplus);
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
    if (!has_odometry()) odometry_pose_ = result.pose;
    const Pose3 believed = filter_.spatial_pose();
    const bool lost = result.state == common::TrackingState::kLost;
    path_.add(*newest_, has_odometry() ? common::to_pose3(odometry_pose_) : believed, believed, lost);
    if (localising_ && !lost) path_.freeze(filter_);
    return result;
  }

  void set_pose(const common::SetPose& command) {
    path_.start_segment();
    place(command.pose, command.covariance);
    monitor_.pose_was_set();
    pose_doubted_ = false;
    search_.end();
  }

  void place(const Pose2& pose, const Eigen::Matrix3d& covariance) {
    forget(filter_.set_pose(pose, covariance));
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    trust_.end();
  }

  /// A map to localise in is the user's and stays.
  void reset() {
    const std::vector<common::Landmark> map = localising_ ? landmarks() : std::vector<common::Landmark>();
    path_.freeze(filter_);
    filter_ = Ekf(options_.filter, options_.motion);
    book_.clear();
    observations_.clear();
    search_.end();
    loop_search_.clear();
    pose_doubted_ = false;
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    last_loop_.reset();
    trust_.end();
    monitor_ = TrackingMonitor(options_.tracking);
    ++epoch_;
    waiting_events_.push_back(event("map_reset", fmt::format("epoch {} begins", epoch_)));
    if (localising_) take_map(map, MapUse::kLocalise);
  }

  VisualSlamOptions options_;
  FeatureSelection selection_;
  std::vector<CameraTracks> cameras_;  // fixed once built: the filter keeps pointers to the cameras
  std::vector<ImageClock> clocks_;     // as cameras_
  std::unique_ptr<FrontEnd> front_end_;
  TurnSearch turn_search_;  // without wheel odometry
  LandmarkBook book_;
  PlaceSearch search_;
  LoopSearch loop_search_;
  bool localising_ = false;    // in a saved map, which stays as it is
  bool placed_ = false;        // the pose was found in the whole map since it was lost
  bool pose_doubted_ = false;  // nothing is known of the pose: features are not looked for near it
  TrackingMonitor monitor_;
  ObservationLog observations_;
  ImageSampler sampler_;
  TrustChain trust_;
  Ekf filter_;
  PathRecorder path_;
  common::OdometryBuffer odometry_;
  std::uint32_t epoch_ = 0;
  std::optional<Nanoseconds> newest_;  // stamp of the newest estimate
  Pose2 odometry_pose_;                // T_odom_base there
  BodyTwist twist_;
  std::optional<Pose3> last_keyframe_;  // by the odometry
  std::optional<Nanoseconds> last_loop_;
  std::vector<common::Event> waiting_events_;
};

common::Result<std::unique_ptr<VisualSlam>> VisualSlam::create(
    const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras,
    std::uint64_t seed, int threads) {
  if (cameras.empty()) return common::invalid_input("visual SLAM: no camera");
  for (const auto& [name, calibration] : cameras) {
    if (calibration.width <= 0 || calibration.height <= 0 || !(calibration.fx > 0.0) || !(calibration.fy > 0.0)) {
      return common::invalid_input(
          fmt::format("visual SLAM: camera '{}' has size {} x {} px and focal lengths {}, {} px; all must be above 0",
                      name, calibration.width, calibration.height, calibration.fx, calibration.fy));
    }
  }
  const FilterOptions& filter = options.filter;
  if (filter.scene_depth_sigma > 0.0 && filter.scene_depth_sigma <= filter.known_depth) {
    return common::invalid_input(fmt::format(
        "visual.filter.scene_depth_sigma: {} must be 0 or above visual.filter.known_depth, {}: else a guessed depth "
        "counts as known",
        filter.scene_depth_sigma, filter.known_depth));
  }
  cv::setNumThreads(std::max(1, threads));
  common::Result<FeatureSelection> selection = FeatureSelection::create(options.selection);
  if (!selection) return tl::unexpected(selection.error());
  return std::unique_ptr<VisualSlam>(
      new VisualSlam(std::make_unique<Implementation>(options, cameras, seed, std::move(*selection))));
}

bool VisualSlam::can_search() const { return implementation_->can_search(); }

common::Result<void> VisualSlam::load(const std::vector<common::Landmark>& map, MapUse use) {
  if (!implementation_->can_search()) {
    return common::invalid_input(
        "visual map: a free camera, and visual.relocalisation.enabled: false, cannot be found in a saved map");
  }
  std::set<std::int64_t> numbers;
  bool recognisable = false;
  for (const common::Landmark& landmark : map) {
    if (!landmark.position.allFinite() || !landmark.covariance.allFinite()) {
      return common::invalid_input(fmt::format("visual map: landmark {} has a place that is no number", landmark.id));
    }
    if (!numbers.insert(landmark.id).second) {
      return common::invalid_input(fmt::format("visual map: two landmarks have the number {}", landmark.id));
    }
    if (!landmark.views.empty()) recognisable = true;
  }
  if (!recognisable) {
    return common::invalid_input(
        fmt::format("visual map: none of its {} landmarks has a view it could be recognised by; map anew", map.size()));
  }
  implementation_->load(map, use);
  return {};
}

VisualSlam::VisualSlam(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
VisualSlam::~VisualSlam() = default;

bool VisualSlam::wants(const common::SensorMessage& message) const { return implementation_->wants(message); }
common::ProcessResult VisualSlam::process(const common::SensorMessage& message) {
  return implementation_->process(message);
}
void VisualSlam::execute(const common::Command& command) { implementation_->execute(command); }
common::Trajectory2 VisualSlam::final_trajectory() const { return common::to_planar(spatial_trajectory()); }
common::Trajectory3 VisualSlam::spatial_trajectory() const { return implementation_->spatial_trajectory(); }
std::vector<common::Landmark> VisualSlam::landmarks() const { return implementation_->landmarks(); }
std::vector<common::Keyframe> VisualSlam::keyframes() const { return implementation_->keyframes(); }
std::vector<common::AnnotatedImage> VisualSlam::sample_images() const { return implementation_->sample_images(); }

}  // namespace slamfuse::visual_slam
