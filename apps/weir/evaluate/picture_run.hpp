// Plays the pictures of a sequence through a pipeline and hands out its results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "evaluate/labelled_folder.hpp"
#include "evaluate/picture_file.hpp"
#include "launch/pipeline_description.hpp"
#include "report.hpp"
#include "weir/result.hpp"

namespace weir::app {

// What a run calls. Errors end the run.
struct RunHandlers {
  // A picture before it is played. An error leaves it out.
  std::function<Status(size_t picture, const DecodedPicture&)> accept;
  // The results of a picture, an object of docs/results.md.
  std::function<Status(size_t picture, const Json& frame)> results;
  // After each picture.
  std::function<void()> progress;
  // A picture that is left out, and a warning of an element.
  std::function<void(const Error&)> warn;
};

// `pipeline` takes pictures (video/x-raw) at its begin and has results at its end. Picture i has
// the time i / frame rate. Errors: OPTION_SYNTAX, those of its elements, SPEC_MISMATCH when
// pictures have no results or several.
Status play_pictures(const PipelineDescription& pipeline, const LabelledSequence& sequence,
                     const RunHandlers& handlers);

}  // namespace weir::app
