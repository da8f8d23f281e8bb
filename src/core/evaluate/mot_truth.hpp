// Reads the files of sequences of MOTChallenge: seqinfo.ini and gt.txt.
// https://motchallenge.net/instructions/
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/evaluate/tracking.hpp"
#include "weir/result.hpp"

namespace weir::evaluate {

struct SequenceInfo {
  std::string name;
  std::string folder = "img1";     // of the pictures, below the sequence's
  std::string extension = ".jpg";  // of the pictures 000001.jpg, 000002.jpg ...
  double frame_rate = 0;
  uint32_t frames = 0, width = 0, height = 0;
};

// OPTION_SYNTAX for lines that cannot be read, LABELS_INVALID for values that are missing or not
// possible.
Result<SequenceInfo> parse_sequence_info(const std::string& path, std::string_view text);

// The truth of a frame: objects to find, and objects that may be found or not, such as people on
// vehicles and reflections.
struct TruthTracks {
  std::vector<TrackedBox> counted, neutral;
};

// A list of tracks for each frame. Lines are frame,id,x,y,width,height,flag,class,visibility, where
// the left upper corner of the picture is 1,1; in what is returned it is 0,0, as in results. An
// object whose flag is 0 is not counted, and neutral if its class is one of MOTChallenge's
// distractors (2, 7, 8, 12). LABELS_INVALID, with the line, for one that cannot be read or
// contradicts another or the sequence.
Result<std::vector<TruthTracks>> parse_mot_truth(const std::string& path, std::string_view text,
                                                 const SequenceInfo& info);

// Leaves out found boxes that match neutral objects, at an overlap of 0.5 and better than counted
// ones.
TrackedFrame without_neutral(const TruthTracks& truth, std::vector<TrackedBox> found);

}  // namespace weir::evaluate
