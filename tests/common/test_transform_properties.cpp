// SPDX-License-Identifier: BSD-3-Clause
// What must hold for every pose and transform type, checked on one set of samples each: random ones, and the corners
// (identity, turns at and next to pi, turns next to nothing, positions from micrometres to a thousand kilometres).
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "common/similarity2.hpp"

namespace slamfuse::common {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurns[] = {0.0, 1e-12,   -1e-8, 0.99e-4,    1.01e-4,     -1.0,
                             1.5, kPi / 2, -3.0,  kPi - 1e-9, -kPi + 1e-9, kPi};
constexpr double kLengths[] = {0.0, 1e-6, 1.0, 1e3, 1e6};
constexpr double kTolerance = 1e-13;  // of the size of the numbers compared

std::vector<Pose2> pose2_samples() {
  std::vector<Pose2> samples;
  for (const double turn : kTurns) {
    for (const double length : kLengths) samples.push_back({length, -0.7 * length, turn});
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 20; ++i) samples.push_back({10 * uniform(random), 10 * uniform(random), kPi * uniform(random)});
  return samples;
}

template <class T>
std::vector<T> samples();

template <>
std::vector<Pose2> samples<Pose2>() {
  return pose2_samples();
}

template <>
std::vector<Pose3> samples<Pose3>() {
  std::vector<Pose3> result;
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (const Pose2& planar : pose2_samples()) {
    const Eigen::Vector3d axis = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    result.push_back(
        {{planar.x, planar.y, 0.3 * planar.x - 1.0}, Eigen::Quaterniond(Eigen::AngleAxisd(planar.theta, axis))});
  }
  return result;
}

template <>
std::vector<Similarity2> samples<Similarity2>() {
  std::vector<Similarity2> result;
  double scale = 1e-3;
  for (const Pose2& pose : pose2_samples()) {
    result.push_back({scale, pose});
    scale = scale > 500.0 ? 1e-3 : scale * 1.9;
  }
  return result;
}

Eigen::Vector2d some_point(const Pose2&) { return {3.0, -4.0}; }
Eigen::Vector3d some_point(const Pose3&) { return {3.0, -4.0, 5.0}; }
Eigen::Vector2d some_point(const Similarity2&) { return {3.0, -4.0}; }

/// The size of the largest number that goes into a product with this transform.
double magnitude(const Pose2& pose) { return 1.0 + pose.translation().norm(); }
double magnitude(const Pose3& pose) { return 1.0 + pose.translation.norm(); }
double magnitude(const Similarity2& t) {
  return (1.0 + t.pose.translation().norm()) * std::max(t.scale, 1.0 / t.scale);
}

void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(angle_difference(a.theta, b.theta), 0.0, kTolerance);
}
void expect_near(const Pose3& a, const Pose3& b, double tolerance) {
  EXPECT_NEAR((a.translation - b.translation).norm(), 0.0, tolerance);
  EXPECT_NEAR(a.rotation.angularDistance(b.rotation), 0.0, 1e-7);  // the arc cosine inside costs half the digits
  EXPECT_NEAR((a.rotation.toRotationMatrix() - b.rotation.toRotationMatrix()).norm(), 0.0, 1e-13);
}
void expect_near(const Similarity2& a, const Similarity2& b, double tolerance) {
  EXPECT_NEAR(a.scale / b.scale, 1.0, kTolerance);
  expect_near(a.pose, b.pose, tolerance);
}

void expect_normal_form(const Pose2& pose) {
  EXPECT_TRUE(pose.is_finite());
  EXPECT_GT(pose.theta, -kPi);
  EXPECT_LE(pose.theta, kPi);
}
void expect_normal_form(const Pose3& pose) {
  EXPECT_TRUE(pose.is_finite());
  EXPECT_NEAR(pose.rotation.norm(), 1.0, 1e-14);
}
void expect_normal_form(const Similarity2& transform) {
  EXPECT_GT(transform.scale, 0.0);
  expect_normal_form(transform.pose);
}

template <class T>
class Transforms : public testing::Test {};
using TransformTypes = testing::Types<Pose2, Pose3, Similarity2>;
TYPED_TEST_SUITE(Transforms, TransformTypes);

TYPED_TEST(Transforms, IdentityChangesNothing) {
  const TypeParam identity;
  for (const TypeParam& a : samples<TypeParam>()) {
    const double tolerance = kTolerance * magnitude(a);
    expect_near(identity * a, a, tolerance);
    expect_near(a * identity, a, tolerance);
  }
  EXPECT_EQ(identity * some_point(identity), some_point(identity));
}

TYPED_TEST(Transforms, InverseUndoesFromBothSides) {
  for (const TypeParam& a : samples<TypeParam>()) {
    const double tolerance = kTolerance * magnitude(a) * magnitude(a.inverse());
    expect_near(a * a.inverse(), TypeParam{}, tolerance);
    expect_near(a.inverse() * a, TypeParam{}, tolerance);
    expect_near(a.inverse().inverse(), a, tolerance);
  }
}

TYPED_TEST(Transforms, ProductsAreAssociativeAndInvertInReverse) {
  const std::vector<TypeParam> all = samples<TypeParam>();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TypeParam& a = all[i];
    const TypeParam& b = all[(i + 17) % all.size()];
    const TypeParam& c = all[(i + 31) % all.size()];
    const double tolerance = kTolerance * magnitude(a) * magnitude(b) * magnitude(c);
    expect_near((a * b) * c, a * (b * c), tolerance);
    expect_near((a * b).inverse(), b.inverse() * a.inverse(),
                kTolerance * magnitude(a.inverse()) * magnitude(b.inverse()) * magnitude(a) * magnitude(b));
  }
}

TYPED_TEST(Transforms, ProductMovesPointsLikeOneAfterTheOther) {
  const std::vector<TypeParam> all = samples<TypeParam>();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TypeParam& a = all[i];
    const TypeParam& b = all[(i + 23) % all.size()];
    const auto point = some_point(a);
    const double tolerance = 10 * kTolerance * magnitude(a) * magnitude(b);
    EXPECT_NEAR(((a * b) * point - a * (b * point)).norm(), 0.0, tolerance);
    EXPECT_NEAR((a.inverse() * (a * point) - point).norm(), 0.0,
                10 * kTolerance * magnitude(a) * magnitude(a.inverse()));
  }
}

TYPED_TEST(Transforms, ResultsKeepTheirNormalForm) {
  const std::vector<TypeParam> all = samples<TypeParam>();
  for (const TypeParam& a : all) {
    expect_normal_form(a.inverse());
    for (const TypeParam& b : all) expect_normal_form(a * b);
  }
}

template <class T>
class PlanarTransforms : public testing::Test {};
using PlanarTypes = testing::Types<Pose2, Similarity2>;
TYPED_TEST_SUITE(PlanarTransforms, PlanarTypes);

TYPED_TEST(PlanarTransforms, MatrixOfAProductIsTheProductOfTheMatrices) {
  const std::vector<TypeParam> all = samples<TypeParam>();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TypeParam& a = all[i];
    const TypeParam& b = all[(i + 29) % all.size()];
    EXPECT_NEAR(((a * b).matrix() - a.matrix() * b.matrix()).norm(), 0.0, kTolerance * magnitude(a) * magnitude(b));
  }
}

TEST(Pose2Properties, LogarithmAndExponentialUndoEachOther) {
  for (const Pose2& pose : pose2_samples()) {
    const double tolerance = 10 * kTolerance * magnitude(pose);
    expect_near(exp_se2(log_se2(pose)), pose, tolerance);
    const Eigen::Vector3d twist = pose.vector();
    EXPECT_NEAR((log_se2(exp_se2(twist)) - twist).norm(), 0.0, tolerance);
  }
}

TEST(Pose2Properties, TwoHalvesOfATwistMakeTheWhole) {
  for (const Pose2& pose : pose2_samples()) {
    const Eigen::Vector3d twist = log_se2(pose);
    const Pose2 half = exp_se2(twist / 2.0);
    expect_near(half * half, pose, 10 * kTolerance * magnitude(pose));
  }
}

TEST(Pose2Properties, AdjointMovesTwistsToTheParentFrame) {
  for (const Pose2& pose : pose2_samples()) {
    const Eigen::Vector3d twist(0.3, -0.2, 0.5);
    expect_near(exp_se2(adjoint(pose) * twist), pose * exp_se2(twist) * pose.inverse(),
                100 * kTolerance * magnitude(pose));
  }
}

/// The Jacobian of a function of (x, y, theta) by central differences.
template <class Function>
Eigen::Matrix3d numeric_jacobian(const Function& function, const Pose2& at) {
  const double step = 1e-6;
  Eigen::Matrix3d jacobian;
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d ahead = at.vector();
    Eigen::Vector3d behind = at.vector();
    ahead(i) += step;
    behind(i) -= step;
    const Pose2 a = function(Pose2{ahead.x(), ahead.y(), ahead.z()});
    const Pose2 b = function(Pose2{behind.x(), behind.y(), behind.z()});
    jacobian.col(i) << (a.x - b.x), (a.y - b.y), angle_difference(a.theta, b.theta);
  }
  return jacobian / (2.0 * step);
}

TEST(Pose2Properties, JacobiansAgreeWithFiniteDifferences) {
  const std::vector<Pose2> all = pose2_samples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Pose2& a = all[i];
    const Pose2& b = all[(i + 13) % all.size()];
    const double tolerance = 1e-8 * (magnitude(a) + magnitude(b));
    const ComposeJacobians jacobians = compose_jacobians(a, b);
    EXPECT_NEAR((jacobians.wrt_a - numeric_jacobian([&](const Pose2& p) { return p * b; }, a)).norm(), 0.0, tolerance);
    EXPECT_NEAR((jacobians.wrt_b - numeric_jacobian([&](const Pose2& p) { return a * p; }, b)).norm(), 0.0, tolerance);
    EXPECT_NEAR((inverse_jacobian(a) - numeric_jacobian([](const Pose2& p) { return p.inverse(); }, a)).norm(), 0.0,
                tolerance);
  }
}

TEST(Pose2Properties, InterpolationStartsAtOnePoseAndEndsAtTheOther) {
  const std::vector<Pose2> all = pose2_samples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Pose2& a = all[i];
    const Pose2& b = all[(i + 19) % all.size()];
    const double tolerance = kTolerance * (magnitude(a) + magnitude(b));
    expect_near(interpolate(a, b, 0.0), a, tolerance);
    expect_near(interpolate(a, b, 1.0), b, tolerance);
    expect_normal_form(interpolate(a, b, 0.3));
    EXPECT_LE(std::abs(angle_difference(interpolate(a, b, 0.5).theta, a.theta)), kPi / 2 + 1e-12);
  }
}

TEST(Pose3Properties, PlanarPosesKeepTheirProductsInSpace) {
  const std::vector<Pose2> all = pose2_samples();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Pose2& a = all[i];
    const Pose2& b = all[(i + 7) % all.size()];
    const double tolerance = 10 * kTolerance * magnitude(a) * magnitude(b);
    expect_near(to_pose2(to_pose3(a)), a, tolerance);
    expect_near(to_pose2(to_pose3(a) * to_pose3(b)), a * b, tolerance);
  }
}

}  // namespace
}  // namespace slamfuse::common
