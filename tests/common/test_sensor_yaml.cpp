// SPDX-License-Identifier: BSD-3-Clause
#include "common/sensor_yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::AllOf;
using ::testing::HasSubstr;

struct BadYaml {
  const char* from;
  const char* to;
  const char* reason;
};

class SensorYamlTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    write_file(folder_.path() / "sensor.yaml", text);
    return folder_.path() / "sensor.yaml";
  }
  static std::string replaced(std::string text, const BadYaml& bad) {
    const std::size_t at = text.find(bad.from);
    EXPECT_NE(at, std::string::npos) << bad.from;
    return text.replace(at, std::string(bad.from).size(), bad.to);
  }
  TemporaryFolder folder_;
};

TEST_F(SensorYamlTest, RefusesBadCameraKeysNamingFileAndKey) {
  const std::array<BadYaml, 14> cases{{
      {"T_BS", "T_XX", "key T_BS is missing"},
      {"-1, 0, 0, 0.2", "-1, 0, 0.5, 0.2", "T_BS is not usable (allowed: a rotation"},
      {"0, 0, 0, 1]", "0, 0, 0]", "a list of 16 numbers"},
      {"[16, 12]", "[0, 12]", "resolution is '0' (allowed: a whole number from 1"},
      {"[16, 12]", "[16.5, 12]", "resolution is '16.5'"},
      {"[16, 12]", "[16]", "resolution"},
      {"resolution", "size", "key resolution is missing"},
      {"[20, 21", "[0, 21", "focal lengths above 0"},
      {"[20, 21", "[.nan, 21", "intrinsics is '.nan' (allowed: a finite number)"},
      {"intrinsics", "intrinsic", "key intrinsics is missing"},
      {"pinhole", "fisheye", "camera_model is 'fisheye' (allowed: pinhole)"},
      {"radial-tangential", "equidistant", "distortion_model is 'equidistant'"},
      {"[-0.1, 0.02, 0.001, 0.002]", "[-0.1, 0.02]", "distortion_coefficients"},
      {"rate_hz: 5", "rate_hz: 0", "rate_hz"},
  }};
  for (const BadYaml& bad : cases) {
    const auto camera = read_camera_yaml(write(replaced(kCameraYaml, bad)));
    ASSERT_FALSE(camera) << bad.to;
    EXPECT_EQ(camera.error().kind, ErrorKind::kInvalidInput);
    EXPECT_THAT(camera.error().message, AllOf(HasSubstr("sensor.yaml"), HasSubstr(bad.reason)));
  }
}

TEST_F(SensorYamlTest, RefusesBadLaserKeysNamingFileAndKey) {
  const std::array<BadYaml, 11> cases{{
      {"sensor_type: laser_2d", "sensor_type: camera", "sensor_type is 'camera'"},
      {"beams: 4", "beams: 0", "beams is '0'"},
      {"beams: 4", "beams: 4.5", "beams is '4.5'"},
      {"beams: 4", "beams: 999999999999", "beams"},
      {"beams: 4\n", "", "key beams is missing"},
      {"angle_increment: 1.0", "angle_increment: 0", "angle_increment is '0' (allowed: not 0)"},
      {"angle_increment: 1.0", "angle_increment: 3.0", "one full turn"},
      {"range_max: 5.0", "range_max: 0.05", "above range_min"},
      {"range_min: 0.1", "range_min: -1", "range_min is '-1'"},
      {"sweep_duration: 0.02", "sweep_duration: nan", "sweep_duration is 'nan'"},
      {"data: [1, 0", "data: [2, 0", "a rotation"},
  }};
  for (const BadYaml& bad : cases) {
    const auto laser = read_laser_yaml(write(replaced(kLaserYaml, bad)));
    ASSERT_FALSE(laser) << bad.to;
    EXPECT_THAT(laser.error().message, AllOf(HasSubstr("sensor.yaml"), HasSubstr(bad.reason)));
  }
}

TEST_F(SensorYamlTest, NamesTheLine) {
  const auto camera = read_camera_yaml(write(replaced(kCameraYaml, {"[16, 12]", "[16, -12]", ""})));
  ASSERT_FALSE(camera);
  EXPECT_THAT(camera.error().message, HasSubstr("sensor.yaml:7: resolution is '-12'"));
}

TEST_F(SensorYamlTest, RefusesWhatIsNoYaml) {
  for (const char* text : {"", "just text", "a: [1, 2", "\x01\x02\x03", "- 1\n- 2\n"}) {
    EXPECT_FALSE(read_camera_yaml(write(text))) << text;
  }
}

TEST_F(SensorYamlTest, ReadsFiveDistortionCoefficientsAndLeavesInformationAlone) {
  const auto camera = read_camera_yaml(write(replaced(kCameraYaml, {"0.002]", "0.002, 0.5]\ncomment: a note", ""})));
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_DOUBLE_EQ(camera->calibration.k3, 0.5);
  EXPECT_DOUBLE_EQ(camera->rate_hz.value(), 5.0);
}

}  // namespace
}  // namespace slamfuse::common
