// SPDX-License-Identifier: BSD-3-Clause
#include "common/sensor_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

constexpr std::uintmax_t kLargestFile = 1U << 20;
constexpr int kMostBeams = 100'000;
constexpr int kLargestSide = 32'768;         ///< [px]
constexpr double kLongestSweep = 10.0;       ///< [s]
constexpr double kLongestReadout = 1.0;      ///< [s]
constexpr double kLongestRange = 100'000.0;  ///< [m]
constexpr double kLowestRate = 0.001;        ///< [Hz]
constexpr double kHighestRate = 100'000.0;   ///< [Hz]
constexpr double kFullTurn = 2.0 * std::numbers::pi;
constexpr double kRounding = 1e-3;  ///< printed increments are rounded, relative
constexpr double kMost = std::numeric_limits<double>::max();

/// The keys of one sensor.yaml. A getter that fails throws YamlError; read_* turn it into an Error.
struct YamlError {
  std::string message;
};

class SensorYaml {
 public:
  explicit SensorYaml(const std::filesystem::path& path) : path_(path.string()) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) throw YamlError{path_ + ": no such file"};
    if (std::filesystem::file_size(path, code) > kLargestFile || code) throw YamlError{path_ + ": larger than 1 MiB"};
    root_ = YAML::LoadFile(path_);
    if (!root_.IsMap()) throw YamlError{path_ + ": not a list of keys and values"};
  }

  bool has(const std::string& key) const { return root_[key].IsDefined(); }

  std::string word(const std::string& key) const {
    const YAML::Node node = required(key);
    if (!node.IsScalar()) refuse(node, key, "one word");
    return node.Scalar();
  }

  /// A word that must be one of `allowed` if the key is there.
  void expect(const std::string& key, const std::vector<std::string>& allowed) const {
    if (!has(key)) return;
    const std::string value = word(key);
    std::string list;
    for (const std::string& one : allowed) {
      if (value == one) return;
      list += (list.empty() ? "" : ", ") + one;
    }
    refuse(root_[key], key, list);
  }

  double real(const std::string& key, double min, double max) const { return number(required(key), key, min, max); }

  int integer(const std::string& key, int min, int max) const { return whole(required(key), key, min, max); }

  std::vector<double> reals(const std::string& key, std::size_t least, std::size_t most) const {
    return list(required(key), key, least, most);
  }

  /// Two whole numbers, width and height.
  std::pair<int, int> resolution() const {
    const YAML::Node node = required("resolution");
    if (!node.IsSequence() || node.size() != 2) refuse(node, "resolution", "[width, height] in pixels");
    return {whole(node[0], "resolution", 1, kLargestSide), whole(node[1], "resolution", 1, kLargestSide)};
  }

  Pose3 mounting() const {
    const YAML::Node node = required("T_BS");
    const YAML::Node data = node.IsMap() ? node["data"] : node;
    if (!data.IsDefined()) refuse(node, "T_BS", "data: [16 numbers]");
    const std::vector<double> numbers = list(data, "T_BS", 16, 16);
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = numbers[static_cast<std::size_t>(i)];
    const std::optional<Pose3> pose = pose3_from_matrix(matrix);
    if (!pose) refuse(node, "T_BS", "a rotation and a translation, last row 0 0 0 1");
    return *pose;
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const {
    refuse(root_[key], key, allowed);
  }

 private:
  [[noreturn]] void refuse(const YAML::Node& node, const std::string& key, const std::string& allowed) const {
    const std::string value = node.IsScalar() ? " is " + in_quotes(node.Scalar()) : " is not usable";
    throw YamlError{path_ + ":" + std::to_string(node.Mark().line + 1) + ": " + key + value + " (allowed: " + allowed +
                    ")"};
  }

  YAML::Node required(const std::string& key) const {
    const YAML::Node node = root_[key];
    if (!node.IsDefined()) throw YamlError{path_ + ": key " + key + " is missing"};
    return node;
  }

  int whole(const YAML::Node& node, const std::string& key, int min, int max) const {
    const std::string allowed = "a whole number from " + std::to_string(min) + " to " + std::to_string(max);
    const std::optional<std::int64_t> value = node.IsScalar() ? parse_integer(node.Scalar()) : std::nullopt;
    if (!value || *value < min || *value > max) refuse(node, key, allowed);
    return static_cast<int>(*value);
  }

  double number(const YAML::Node& node, const std::string& key, double min, double max) const {
    const std::optional<double> value = node.IsScalar() ? parse_real(node.Scalar()) : std::nullopt;
    if (!value) refuse(node, key, "a finite number");
    if (*value < min || *value > max) {
      refuse(node, key, max == kMost ? "at least " + shown(min) : shown(min) + " to " + shown(max));
    }
    return *value;
  }

  std::vector<double> list(const YAML::Node& node, const std::string& key, std::size_t least, std::size_t most) const {
    if (!node.IsSequence() || node.size() < least || node.size() > most) {
      refuse(node, key,
             "a list of " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) + " numbers");
    }
    std::vector<double> values;
    for (const YAML::Node& element : node) values.push_back(number(element, key, -kMost, kMost));
    return values;
  }

  static std::string shown(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  }

  std::string path_;
  YAML::Node root_;
};

/// The readout time [s] in a shutter's description such as "rolling, 0.016 s from the first row to the last; ...". 0
/// for any other description: a global shutter, or words this reader does not know.
double readout_of(const std::string& shutter) {
  const std::string rolling = "rolling, ";
  if (shutter.rfind(rolling, 0) != 0) return 0.0;
  const std::size_t end = shutter.find(" s", rolling.size());
  if (end == std::string::npos) return 0.0;
  const std::optional<double> readout = parse_real(shutter.substr(rolling.size(), end - rolling.size()));
  return readout && *readout > 0.0 && *readout < kLongestReadout ? *readout : 0.0;
}

CameraYaml camera_from(const SensorYaml& yaml) {
  yaml.expect("sensor_type", {"camera"});
  yaml.expect("camera_model", {"pinhole"});
  yaml.expect("distortion_model", {"radial-tangential", "radtan", "plumb_bob"});
  CameraYaml camera;
  CameraCalibration& calibration = camera.calibration;
  calibration.T_base_camera = yaml.mounting();
  std::tie(calibration.width, calibration.height) = yaml.resolution();

  const std::vector<double> intrinsics = yaml.reals("intrinsics", 4, 4);
  calibration.fx = intrinsics[0];
  calibration.fy = intrinsics[1];
  calibration.cx = intrinsics[2];
  calibration.cy = intrinsics[3];
  if (calibration.fx <= 0.0 || calibration.fy <= 0.0) {
    yaml.refuse("intrinsics", "focal lengths above 0: [fu, fv, cu, cv]");
  }

  const std::vector<double> distortion = yaml.reals("distortion_coefficients", 4, 5);
  calibration.k1 = distortion[0];
  calibration.k2 = distortion[1];
  calibration.p1 = distortion[2];
  calibration.p2 = distortion[3];
  calibration.k3 = distortion.size() > 4 ? distortion[4] : 0.0;

  if (yaml.has("shutter")) calibration.readout = readout_of(yaml.word("shutter"));
  if (yaml.has("rate_hz")) camera.rate_hz = yaml.real("rate_hz", kLowestRate, kHighestRate);
  return camera;
}

LaserCalibration laser_from(const SensorYaml& yaml) {
  yaml.expect("sensor_type", {"laser_2d", "laser"});
  LaserCalibration laser;
  laser.T_base_laser = yaml.mounting();
  laser.angle_min = yaml.real("angle_min", -kFullTurn, kFullTurn);
  laser.angle_increment = yaml.real("angle_increment", -kFullTurn, kFullTurn);
  laser.beams = yaml.integer("beams", 1, kMostBeams);
  laser.range_min = yaml.real("range_min", 0.0, kLongestRange);
  laser.range_max = yaml.real("range_max", 0.0, kLongestRange);
  laser.sweep_duration = yaml.real("sweep_duration", 0.0, kLongestSweep);
  const double turn = std::abs(laser.angle_increment) * (laser.beams - 1);
  if (laser.angle_increment == 0.0) yaml.refuse("angle_increment", "not 0");
  if (turn > kFullTurn * (1.0 + kRounding)) {
    yaml.refuse("angle_increment", "beams within one full turn, here they span " + std::to_string(turn) + " rad");
  }
  if (laser.range_max <= laser.range_min) yaml.refuse("range_max", "above range_min");
  return laser;
}

/// Runs one of the functions above; what it or yaml-cpp throws becomes an Error.
template <class Read>
auto read_sensor_yaml(const std::filesystem::path& path, Read read) -> Result<decltype(read(SensorYaml(path)))> {
  try {
    return read(SensorYaml(path));
  } catch (const YamlError& error) {
    return invalid_input(error.message);
  } catch (const YAML::Exception& error) {
    return invalid_input(path.string() + ":" + std::to_string(error.mark.line + 1) + ": not YAML: " + error.msg);
  }
}

}  // namespace

Result<CameraYaml> read_camera_yaml(const std::filesystem::path& path) { return read_sensor_yaml(path, camera_from); }

Result<LaserCalibration> read_laser_yaml(const std::filesystem::path& path) {
  return read_sensor_yaml(path, laser_from);
}

}  // namespace slamfuse::common
