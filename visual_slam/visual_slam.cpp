// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/visual_slam.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <span>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "common/angle.hpp"
#include "visual_slam/camera_clocks.hpp"
#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/dead_reckoning.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/estimate_judge.hpp"
#include "visual_slam/feature_selection.hpp"
#include "visual_slam/feature_supply.hpp"
#include "visual_slam/floor_reckoning.hpp"
#include "visual_slam/image_sampler.hpp"
#include "visual_slam/landmark_book.hpp"
#include "visual_slam/map_search.hpp"
#include "visual_slam/observation_log.hpp"
#include "visual_slam/path_recorder.hpp"
#include "visual_slam/picture.hpp"
#include "visual_slam/saved_map.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;
using common::Pose2;
using common::Pose3;

constexpr double kUnknown = 100.0;  // [m], [rad] standard deviation of a pose nothing is known of

std::set<LandmarkId> numbers(const std::vector<Track>& tracks) {
  std::set<LandmarkId> result;
  for (const Track& track : tracks) result.insert(track.landmark);
  return result;
}

std::vector<LandmarkId> numbers_in_order(const std::vector<Track>& tracks) {
  std::vector<LandmarkId> result;
  for (const Track& track : tracks) result.push_back(track.landmark);
  return result;
}

/// The features that are in the pictures before and now.
std::vector<FollowedFeature> followed_features(const std::vector<Track>& before, const std::vector<Track>& now) {
  std::vector<FollowedFeature> features;
  for (const Track& track : now) {
    const auto last = std::find_if(before.begin(), before.end(),
                                   [&track](const Track& one) { return one.landmark == track.landmark; });
    if (last != before.end()) features.push_back({last->pixel, track.pixel});
  }
  return features;
}

}  // namespace

class VisualSlam::Implementation {
 public:
  Implementation(const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras,
                 std::uint64_t seed, std::size_t most_kept, FeatureSelection selection)
      : options_(for_cameras(options, cameras.size())),
        cameras_(tracks_of(cameras)),
        clocks_(options.image_clock, options.turn_search, cameras_),
        features_(options, std::move(selection), cameras.size()),
        floor_(options_.floor_speed, cameras.size()),
        book_(options),
        search_(options, seed),
        judge_(options),
        observations_(options.map),
        filter_(new_filter()),
        path_(most_kept),
        reckoning_(options) {}

  bool wants(const common::SensorMessage& message) const {
    if (const auto* image = std::get_if<common::Image>(&message)) return camera_index(image->sensor).has_value();
    return reckoning_.by_wheels() && std::holds_alternative<common::WheelOdometry>(message);
  }

  common::ProcessResult process(const common::SensorMessage& message) {
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
      reckoning_.add(*odometry);
      clocks_.add(*odometry);
    }
    common::ProcessResult result;
    if (const auto* image = std::get_if<common::Image>(&message)) {
      result = process_image(by_odometry_clock(*image));
      withhold_past(result.estimate);
    }
    return result;
  }

  void execute(const common::Command& command) {
    clocks_.forget_kept();
    if (const auto* set = std::get_if<common::SetPose>(&command)) set_pose(*set);
    if (std::holds_alternative<common::Reset>(command)) {
      continued_map_.clear();
      unit_is_given_ = localising_;
      reset();
    }
    if (std::holds_alternative<common::Relocalise>(command)) relocalise();
  }

  /// Whether a pose can be found in the whole map.
  bool can_search() const { return search_.is_possible(filter_); }

  void load(const std::vector<common::Landmark>& map, MapUse use) {
    localising_ = false;
    unit_is_given_ = true;
    clocks_.forget_kept();
    if (newest_ || epoch_ > 0) {
      reset();
    } else {
      filter_ = new_filter();
    }
    take_map(map, use);
    continued_map_ = use == MapUse::kContinue && reckoning_.by_wheels() ? map : std::vector<common::Landmark>();
  }

  common::Trajectory3 spatial_trajectory() const { return path_.path(filter_); }

  std::vector<common::Landmark> landmarks() const { return book_.landmarks(filter_); }

  std::vector<common::Keyframe> keyframes() const {
    std::vector<Camera> cameras;
    for (const CameraTracks& seeing : cameras_) cameras.push_back(seeing.camera);
    return keyframes_of(observations_, cameras, spatial_trajectory(), filter_.lever_scale());
  }

  std::vector<common::AnnotatedImage> sample_images() const { return sampler_.images(); }

 private:
  static VisualSlamOptions for_cameras(VisualSlamOptions options, std::size_t cameras) {
    options.motion = visual_slam::for_cameras(options.motion, cameras);
    // Several cameras see more parallax and have less need of it; with it they were no better (README).
    const bool needs_floor = cameras == 1 && options.motion.model == MotionModelKind::kConstantVelocity;
    options.floor_speed.enabled = options.floor_speed.enabled && needs_floor;
    return options;
  }

  /// Whether the floor may choose the map's unit: not where a loaded map has.
  bool reads_floor() const {
    const auto sees_floor = [](const CameraTracks& seeing) { return FloorSpeed::may_see_floor(seeing.camera); };
    return options_.floor_speed.enabled && !unit_is_given_ && std::any_of(cameras_.begin(), cameras_.end(), sees_floor);
  }

  /// A filter that knows nothing. If the floor tells metres, the lever arm is known in the map's unit.
  Ekf new_filter() const {
    MotionOptions motion = options_.motion;
    if (reads_floor()) motion.constant_velocity.lever_scale_sigma = 0.0;
    return {options_.filter, motion};
  }

  static std::vector<CameraTracks> tracks_of(const std::map<std::string, common::CameraCalibration>& cameras) {
    std::vector<CameraTracks> tracks;
    for (const auto& [name, calibration] : cameras) tracks.emplace_back(Camera(name, calibration));
    return tracks;
  }

  std::optional<std::size_t> camera_index(const std::string& name) const {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (cameras_[i].camera.name == name) return i;
    }
    return std::nullopt;
  }

  /// The image with its stamp as its camera's clock is believed to be off the wheel odometry's. When that changes the
  /// map, made with odometry of other times, is of no use, and is made anew from the images kept.
  common::Image by_odometry_clock(common::Image image) {
    const std::optional<std::size_t> index = camera_index(image.sensor);
    if (!index || !reckoning_.by_wheels() || !has_size_of(cameras_[*index].camera.calibration, image)) return image;
    const std::vector<std::size_t> changed = clocks_.watch(*index, image);
    for (const std::size_t camera : changed) {
      waiting_events_.push_back(
          event("clock_offset",
                fmt::format("stamps of {} are moved by {:+.1f} ms, where the turns in its pictures fit the "
                            "wheel odometry's; the map is made anew",
                            cameras_[camera].camera.name, 1e3 * common::to_seconds(clocks_.correction(camera)))));
    }
    if (!changed.empty()) remake_map();
    clocks_.keep(image);
    if (!clocks_.may_change()) continued_map_.clear();
    image.stamp += clocks_.correction(*index);
    return image;
  }

  /// From the images that were kept, by the stamps as they are believed now. What is estimated on the way goes into the
  /// path only, its events nowhere: they are of times past.
  void remake_map() {
    reset();
    if (!continued_map_.empty()) take_map(continued_map_, MapUse::kContinue);
    const std::vector<common::Image> kept = clocks_.kept();
    if (kept.empty()) return;
    path_.forget_since(clocks_.first_kept());
    sampler_ = {};
    newest_.reset();
    for (CameraTracks& camera : cameras_) camera.restart();
    const std::vector<common::Event> events = std::exchange(waiting_events_, {});
    for (const common::Image& image : kept) process_image(image);
    waiting_events_ = events;
  }

  /// Stamps that were corrected backwards come a second time: what is estimated until they are new is not told. A step
  /// back by more than a correction can be is the clock's own, and from there on all is new.
  void withhold_past(std::optional<common::PoseEstimate>& estimate) {
    if (!estimate) return;
    const Nanoseconds largest_step = common::from_seconds(2.0 * options_.image_clock.most_offset);
    const Nanoseconds back = newest_told_ ? *newest_told_ - estimate->stamp : 0;
    if (back > 0 && back <= largest_step) {
      waiting_events_ = std::move(estimate->events);
      estimate.reset();
    } else {
      newest_told_ = estimate->stamp;
    }
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
    if (!reckoning_.reaches(image.stamp)) {
      return fmt::format("no wheel odometry at stamp {}: the planar filter needs it", image.stamp);
    }
    return std::nullopt;
  }

  /// The pipeline: one image is one update at its own stamp.
  common::ProcessResult process_image(const common::Image& image) {
    if (std::optional<std::string> reason = refuse(image)) return {.estimate = {}, .rejected = std::move(reason)};
    CameraTracks& seeing = cameras_[*camera_index(image.sensor)];
    const cv::Mat picture = picture_of(image);
    const double seconds = newest_ ? common::to_seconds(image.stamp - *newest_) : 0.0;
    reckoning_.predict(filter_, newest_, image.stamp);
    newest_ = seeing.newest = image.stamp;
    std::vector<common::Event> events;
    ImageEvidence evidence;
    if (seeing.is_frozen(image, reckoning_.pose())) {
      if (reads_floor()) floor_.skip(filter_, seconds);
      judge(evidence, events);
      return {.estimate = estimate({}, {}, std::move(events)), .rejected = {}};
    }
    const bool exposed = is_exposed(picture);
    std::vector<Track> seen = exposed ? follow(seeing, picture, evidence) : std::vector<Track>{};
    UpdateReport report;
    auto floor = FloorReckoning::Verdict::kSilent;
    if (reads_floor()) floor = read_floor(seeing, exposed ? picture : cv::Mat(), seconds, seen, report);
    if (!reckoning_.by_wheels()) report = update(seeing, seen, report);
    const std::size_t followed = seen.size();
    if (exposed && !search_.pose_is_doubted()) recognise(seeing, picture, seen);
    report = update(seeing, seen, report);
    account(seeing, seen, report, events);
    if (!localising_) {
      book_.learn_looks(filter_, seeing.camera, picture, seeing.tracks);
      if (!search_.pose_is_doubted()) keep_pose(image.stamp);
    }
    evidence.inliers = report.inliers;
    evidence.textured = exposed && judge_.asks_for_texture(evidence) && has_texture(seeing);
    evidence.doubted = judge_.doubts(filter_, book_, seeing.tracks, report, *newest_, events);
    judge(evidence, events);
    if (exposed) {
      search_map(seeing, picture);
      close_loop(seeing, picture, events);
    }
    map_anew(floor, seeing, events);
    const std::size_t known = seeing.tracks.size();
    if (exposed && !localising_ && judge_.map_may_grow()) add_features(seeing, picture);
    remember(seeing, image, seen, report, followed, known);
    if (!localising_) limit_map();
    return {.estimate = estimate(seen, report, std::move(events)), .rejected = {}};
  }

  /// Corrects the speed by the floor: after the landmarks of known depth, which come first in `seen` then, and before
  /// those that learn theirs by it.
  FloorReckoning::Verdict read_floor(const CameraTracks& seeing, const cv::Mat& picture, double seconds,
                                     std::vector<Track>& seen, UpdateReport& report) {
    const bool metric = floor_.tells_metres(*newest_);
    filter_.set_metres_are_told(metric);
    if (metric) floor_.age(filter_, numbers_in_order(seen), seconds);
    const auto unknown = std::stable_partition(
        seen.begin(), seen.end(), [this](const Track& track) { return filter_.knows_depth(track.landmark); });
    const std::vector<Track> known(seen.begin(), unknown);
    const bool landmarks_speak = metric && std::ssize(known) >= options_.filter.min_known_depths;
    if (landmarks_speak) report = update(seeing, known, report);
    const std::vector<LandmarkId> landmarks = numbers_in_order(known);
    const std::vector<FollowedFeature> followed = followed_features(seeing.tracks, seen);
    const auto verdict = floor_.read(filter_, {.camera_index = index_of(seeing),
                                               .camera = seeing.camera,
                                               .picture = picture,
                                               .stamp = *newest_,
                                               .seconds = seconds,
                                               .landmarks = landmarks,
                                               .landmarks_spoke = landmarks_speak,
                                               .followed = followed});
    filter_.set_metres_are_told(floor_.tells_metres(*newest_));
    reckoning_.corrected(filter_);
    return verdict;
  }

  /// Drops what the floor contradicts: what is seen, or all of a map whose unit was a wrong guess.
  void map_anew(FloorReckoning::Verdict floor, const CameraTracks& seeing, std::vector<common::Event>& events) {
    const bool all = floor == FloorReckoning::Verdict::kWrongGuess;
    if (!all && floor != FloorReckoning::Verdict::kContradicted) return;
    std::set<LandmarkId> wrong;
    for (const Track& track : seeing.tracks) wrong.insert(track.landmark);
    if (all) {
      for (const LandmarkId id : book_.known(filter_)) wrong.insert(id);
    }
    if (wrong.empty()) return;
    drop({wrong.begin(), wrong.end()});
    events.push_back(
        event("scale_contradicted", "the floor says another speed than what is mapped here, which is mapped anew"));
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
    return features_.follow(index_of(seeing), seeing.camera, picture, std::move(expected));
  }

  /// Adds what is recognised in the picture, of the filter and, where it lacks features, of those that have left it.
  void recognise(const CameraTracks& seeing, const cv::Mat& picture, std::vector<Track>& seen) {
    const std::vector<Track> recognised =
        book_.recognise(filter_, seeing.camera, reckoning_.twist(), picture, numbers(seen), judge_.map_may_grow());
    seen.insert(seen.end(), recognised.begin(), recognised.end());
    if (!judge_.map_may_grow() && !search_.was_placed()) return;
    const int missing = features_.missing(seen.size());
    const std::vector<Track> recalled = book_.recall(filter_, seeing.camera, reckoning_.twist(), picture, missing);
    seen.insert(seen.end(), recalled.begin(), recalled.end());
  }

  std::size_t index_of(const CameraTracks& seeing) const { return static_cast<std::size_t>(&seeing - cameras_.data()); }

  /// Corrects the filter by what was seen and is not in the report `so_far`; returns the report on all.
  UpdateReport update(const CameraTracks& seeing, const std::vector<Track>& seen, const UpdateReport& so_far) {
    const std::size_t done = so_far.accepted.size();
    std::vector<Measurement> measurements;
    for (const Track& track : std::span(seen).subspan(done)) {
      measurements.push_back(
          {track.landmark, make_bearing(seeing.camera, track.pixel, options_.filter.pixel_sigma, reckoning_.twist())});
    }
    UpdateReport report = filter_.update(seeing.camera, measurements);
    reckoning_.corrected(filter_);
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
    judge_.tell_loop(back_after_long, *newest_, events);
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

  /// Whether the image shows enough that could be followed.
  bool has_texture(const CameraTracks& seeing) {
    const int enough = options_.tracking.min_inliers;
    return static_cast<int>(features_.any(index_of(seeing), enough).size()) >= enough;
  }

  void judge(const ImageEvidence& evidence, std::vector<common::Event>& events) {
    if (judge_.judge(*newest_, evidence, events)) search_.lose();
  }

  Glimpse glimpse(const CameraTracks& seeing) const {
    return {*newest_, reckoning_.pose(), &seeing.camera, reckoning_.twist(), filter_.lever_scale()};
  }

  /// Any features of the picture seen last, for those who ask.
  MapSearch::Features features_of(const CameraTracks& seeing) {
    return [this, index = index_of(seeing)](int wanted) { return features_.any(index, wanted); };
  }

  /// Looks for the pose in the whole map while it is lost or what is seen contradicts it. What is found counts when the
  /// next image agrees: until then the state stays as it is.
  void search_map(const CameraTracks& seeing, const cv::Mat& picture) {
    if (judge_.map_may_grow() && !judge_.is_lost()) {
      search_.end();
      return;
    }
    if (!can_search()) return;
    const auto found = search_.find_place(
        filter_, [this] { return landmarks(); }, glimpse(seeing), picture, features_of(seeing));
    if (!found) return;
    if (found->elsewhere) {
      path_.restart_since(found->since);
      place(found->place.pose, found->place.covariance);
    } else {
      filter_.correct_pose(found->place.pose, found->place.covariance);
    }
  }

  /// Corrects the pose, and with it the map, by an old part of the map that is seen from where it should not be.
  void close_loop(const CameraTracks& seeing, const cv::Mat& picture, std::vector<common::Event>& events) {
    if (!can_search() || localising_) return;
    if (!judge_.is_tracking()) {
      search_.interrupt_loops();
      return;
    }
    const auto old_map = [this](Nanoseconds stamp) { return book_.unseen_since(filter_, stamp); };
    const auto found = search_.find_loop(filter_, old_map, glimpse(seeing), picture, features_of(seeing));
    if (!found) return;
    const Pose2 drift = filter_.pose().inverse() * found->pose;
    filter_.correct_pose(found->pose, found->covariance);
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
    judge_.lose();
    search_.doubt_pose();
  }

  void keep_pose(Nanoseconds stamp) {
    const Pose3 here = reckoning_.by_wheels() ? common::to_pose3(reckoning_.pose()) : filter_.spatial_pose();
    const Pose3 since = last_keyframe_ ? last_keyframe_->inverse() * here : Pose3{};
    if (!last_keyframe_ || since.translation.norm() > options_.map.keyframe_distance ||
        Eigen::AngleAxisd(since.rotation).angle() > common::to_radians(options_.map.keyframe_turn)) {
      filter_.add_keyframe(stamp, options_.map.max_keyframes);
      book_.archived().follow(filter_);
      last_keyframe_ = here;
    }
  }

  void add_features(CameraTracks& seeing, const cv::Mat& picture) {
    for (const auto& [pixel, object] : features_.refill(index_of(seeing), picture, seeing.tracks)) {
      const LandmarkId id = book_.enter(picture, pixel, *newest_, object);
      filter_.add_landmark(id, seeing.camera,
                           make_bearing(seeing.camera, pixel, options_.filter.pixel_sigma, reckoning_.twist()),
                           *newest_);
      seeing.tracks.push_back({id, pixel});
    }
  }

  /// Keeps what the map's export and the report show of the image: the first `followed` of `seen` come from the image
  /// before, the others were recognised; the tracks from `known` on are new.
  void remember(const CameraTracks& seeing, const common::Image& image, const std::vector<Track>& seen,
                const UpdateReport& report, std::size_t followed, std::size_t known) {
    if (judge_.is_tracking()) observations_.offer(index_of(seeing), image.stamp, reckoning_.pose(), seeing.tracks);
    if (!sampler_.wants(image.sensor, image.stamp)) return;
    common::AnnotatedImage sample{image, judge_.state(), {}};
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
    return visual_event(newest_.value_or(0), std::move(kind), std::move(detail));
  }

  common::PoseEstimate estimate(const std::vector<Track>& seen, const UpdateReport& report,
                                std::vector<common::Event> events) {
    common::PoseEstimate result;
    result.stamp = *newest_;
    result.source = common::PoseSource::kVisual;
    result.map_epoch = epoch_;
    result.pose = filter_.pose();
    result.covariance = filter_.pose_covariance();
    result.state = judge_.state();
    result.health.tracked_features = static_cast<int>(seen.size());
    result.health.inliers = report.inliers;
    if (report.inliers > 0) result.health.innovation = report.mean_nis;
    for (common::Event& waiting : waiting_events_) {
      waiting.stamp = *newest_;
      events.push_back(std::move(waiting));
    }
    waiting_events_.clear();
    result.events = std::move(events);
    reckoning_.estimated(filter_);
    const bool lost = result.state == common::TrackingState::kLost;
    path_.add(*newest_, reckoning_.by_wheels() ? common::to_pose3(reckoning_.pose()) : filter_.spatial_pose(), lost,
              filter_, observations_);
    if (localising_ && !lost) path_.freeze(filter_);
    return result;
  }

  void set_pose(const common::SetPose& command) {
    path_.start_segment();
    place(command.pose, command.covariance);
    judge_.pose_was_set();
    search_.pose_was_set();
  }

  void place(const Pose2& pose, const Eigen::Matrix3d& covariance) {
    forget(filter_.set_pose(pose, covariance));
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    judge_.moved_elsewhere();
  }

  /// A map to localise in is the user's and stays.
  void reset() {
    const std::vector<common::Landmark> map = localising_ ? landmarks() : std::vector<common::Landmark>();
    path_.freeze(filter_);
    filter_ = new_filter();
    book_.clear();
    observations_.clear();
    search_.clear();
    floor_ = FloorReckoning(options_.floor_speed, cameras_.size());
    for (CameraTracks& camera : cameras_) camera.tracks.clear();
    last_keyframe_.reset();
    judge_.clear();
    ++epoch_;
    waiting_events_.push_back(event("map_reset", fmt::format("epoch {} begins", epoch_)));
    if (localising_) take_map(map, MapUse::kLocalise);
  }

  VisualSlamOptions options_;
  std::vector<CameraTracks> cameras_;  // fixed once built: filter and clocks keep pointers to the cameras
  CameraClocks clocks_;
  FeatureSupply features_;
  FloorReckoning floor_;
  LandmarkBook book_;
  MapSearch search_;
  bool localising_ = false;     // in a saved map, which stays as it is
  bool unit_is_given_ = false;  // by a loaded map
  EstimateJudge judge_;
  ObservationLog observations_;
  ImageSampler sampler_;
  Ekf filter_;
  PathRecorder path_;
  DeadReckoning reckoning_;
  std::uint32_t epoch_ = 0;
  std::optional<Nanoseconds> newest_;       // stamp of the newest estimate
  std::optional<Nanoseconds> newest_told_;  // of those that left the module
  std::vector<common::Landmark>
      continued_map_;                   // the saved map that is continued, while it may have to be loaded again
  std::optional<Pose3> last_keyframe_;  // by the odometry
  std::vector<common::Event> waiting_events_;
};

common::Result<std::unique_ptr<VisualSlam>> VisualSlam::create(
    const VisualSlamOptions& options, const std::map<std::string, common::CameraCalibration>& cameras,
    std::uint64_t seed, int threads, std::size_t most_kept) {
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
      new VisualSlam(std::make_unique<Implementation>(options, cameras, seed, most_kept, std::move(*selection))));
}

bool VisualSlam::can_search() const { return implementation_->can_search(); }

common::Result<void> VisualSlam::load(const std::vector<common::Landmark>& map, MapUse use) {
  if (!implementation_->can_search()) {
    return common::invalid_input(
        "visual map: a free camera, and visual.relocalisation.enabled: false, cannot be found in a saved map");
  }
  if (common::Result<void> usable = check_saved_map(map); !usable) return usable;
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
