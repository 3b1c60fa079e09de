// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace slamfuse::common {

/// Follows a rawlog in the pieces in which MRPT reads it, and says what MRPT would take on trust: numbers of objects
/// that it makes room for, or makes, before it reads on, an object of another class than it uses. One guard an object.
class RawlogGuard {
 public:
  /// Why MRPT must not read on behind this piece; empty if it may. The piece must not be empty.
  std::string flaw_of(std::string_view piece);

 private:
  /// A frame holds the observations of one moment. MRPT makes room for as many as the file says before it reads one.
  /// Behind a frame's name come its version, in old ones a stamp of 8 bytes, and the number of its observations.
  std::string flaw_of_frame(std::string_view piece);
  /// A collection of actions uses what it holds as actions, without a look: a null pointer where it is none. The name
  /// of what it holds comes behind its length, that behind the number of actions or the mark at the end of an object.
  std::string flaw_of_actions(std::string_view piece);
  /// A movement tells by a number (from version 2 on) whether odometry follows, a CPose2D with its motion model, or
  /// some CPosePDF. Where another object follows than a CPosePDF, MRPT uses a null pointer; of a particle model it
  /// draws as many particles as the file says.
  std::string flaw_of_movement(std::string_view piece);

  /// What comes next of a collection of actions.
  enum class Actions { kNone, kNumber, kFirstLength, kFirstName, kAny, kLength, kName };
  /// What comes next of a movement.
  enum class Movement { kNone, kVersion, kMethod, kPdf, kOdometry, kPoseVersion, kModel };

  bool frame_begun_ = false;  ///< the name of a frame was read, its number of observations was not
  Actions actions_ = Actions::kNone;
  bool several_ = false;  ///< actions in the collection
  std::size_t name_ = 0;  ///< length of the name that may come next
  Movement movement_ = Movement::kNone;
  int version_ = 0;  ///< of the movement
  int numbers_ = 0;  ///< of the motion model that were read
};

}  // namespace slamfuse::common
