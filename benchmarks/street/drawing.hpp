// Draws people, areas and counts on pictures as a program with OpenCV does.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <opencv2/core.hpp>
#include <span>

#include "core/zone/zone_counter.hpp"
#include "detector.hpp"

namespace street {

void draw_people(std::span<const Detection> people, cv::Mat* picture);
void draw_zones(const weir::zone::ZoneCounter& counter, cv::Mat* picture);

}  // namespace street
