// A folder of pictures with the truth about them, in one of the usual layouts:
//   COCO            an annotation file (JSON) and pictures
//   classes         a folder for each class with its pictures
//   class maps      images/NAME.jpg and masks/NAME.png
//   MOTChallenge    seqinfo.ini, gt/gt.txt and img1/000001.jpg ..., or folders of such sequences
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "commands.hpp"
#include "core/evaluate/mot_truth.hpp"
#include "core/evaluate/objects.hpp"
#include "weir/result.hpp"

namespace weir::app {

enum class Labelled { Objects, Classes, Maps, Tracks };

struct LabelledPicture {
  std::string path{};
  // What the truth says of it, by the kind of the folder.
  uint32_t width = 0, height = 0;                // 0: not known
  std::vector<evaluate::TruthObject> objects{};  // Objects
  size_t class_index = 0;                        // Classes
  std::string mask{};                            // Maps: path of a PNG file
  evaluate::TruthTracks tracks{};                // Tracks
};

// Pictures that are played as one stream.
struct LabelledSequence {
  std::string name{};
  double frame_rate = 1;
  std::vector<LabelledPicture> pictures{};
};

struct LabelledFolder {
  Labelled kind = Labelled::Objects;
  std::string truth{};                        // path of the annotation file or folder, for messages
  std::vector<std::string> categories{};      // names; of Maps and Tracks: none
  size_t key_points = 0;                      // of Objects
  std::vector<LabelledSequence> sequences{};  // one, except of Tracks
  std::vector<Error> warnings{};              // what is left out

  size_t pictures() const noexcept;
};

// Recognises the layout and reads the truth; `options.limit` pictures at most, of each sequence.
// FILE_NOT_FOUND for a folder that does not exist, is empty or has no known layout; LABELS_INVALID
// for truth that cannot be read or contradicts itself.
Result<LabelledFolder> read_labelled_folder(const EvaluateOptions& options);

}  // namespace weir::app
