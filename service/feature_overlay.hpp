// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/annotated_image.hpp"

namespace slamfuse::service {

/// An image as an <svg> element with its features marked on it; the picture is a JPEG of at most 480 px width inside
/// it (about 20 kB). Kinds of features differ in shape as well as in colour. Empty text when the image has no pixels.
std::string feature_overlay(const common::AnnotatedImage& image);

/// What the marks mean, as an <svg> element.
std::string feature_legend();

/// What is on an image in words: "34 followed, 2 recognised, 1 rejected, 12 new; TRACKING".
std::string features_in_words(const common::AnnotatedImage& image);

}  // namespace slamfuse::service
