// `weir evaluate MODEL FOLDER`: measures how good the results of a pipeline are on labelled data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "commands.hpp"
#include "evaluate/comparison.hpp"
#include "evaluate/picture_run.hpp"
#include "evaluate/progress_bar.hpp"
#include "report.hpp"
#include "run/html.hpp"
#include "try/try_model.hpp"
#include "try/try_pipeline.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// What is played: a pipeline as it is, or one that is made for a model.
struct Played {
  std::string name;
  PipelineDescription pipeline;
  std::vector<std::string> labels;  // of a model, if they are known
};

// Scores and ranks need results that `weir try` would not show.
Properties decoder_properties(Labelled kind) {
  switch (kind) {
    case Labelled::Objects:
      return {{"threshold", "0.001"}, {"max-results", "100"}};
    case Labelled::Classes:
      return {{"threshold", "0"}, {"max-results", "5"}};
    case Labelled::Maps:
    case Labelled::Tracks:
      break;
  }
  return {};
}

Result<Played> played(const EvaluateOptions& options, const std::string& model, Labelled kind) {
  constexpr size_t kMaxCharacters = 100;
  std::error_code ignored;
  if (model.find('!') != std::string::npos && !fs::exists(model, ignored))
    return Played{shortened(model, kMaxCharacters), PipelineDescription().text(model), {}};
  if (kind == Labelled::Tracks)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "a model alone does not track objects",
                 .offered = model,
                 .needed = "a pipeline whose results have tracks, because the truth has tracks: " +
                           options.folder,
                 .fix =
                     "weir evaluate 'tensor_preprocess ... ! tensor_filter ... ! tensor_decoder "
                     "... ! TRACKER' " +
                     shell_word(options.folder)};
  TryOptions tried;
  tried.model = model;
  tried.labels = options.labels;
  tried.mode = options.mode;
  tried.head = options.head;
  tried.engine = options.engine;
  auto known = try_model(tried);
  if (!known) return known.error();
  if (!options.json)
    for (const auto& note : known->notes)
      std::fprintf(stderr, "%s\n", printable_text(note).c_str());
  for (auto& property : decoder_properties(kind)) known->decoder.push_back(std::move(property));
  return Played{fs::path(known->path).filename().string(),
                PipelineDescription().text("videoconvert ! ").append(result_elements(*known)),
                std::move(known->names)};
}

class Evaluating {
 public:
  Evaluating(const EvaluateOptions& options, const LabelledFolder& folder,
             EvaluationComparison* out)
      : options_(options), folder_(folder), out_(*out) {
    for (const Error& warning : folder.warnings) warn(warning);
  }

  Status run(const std::string& model) {
    const auto what = played(options_, model, folder_.kind);
    if (!what) return what.error();
    auto evaluator = make_evaluator(folder_, options_, what->labels);
    if (!evaluator) return evaluator.error();
    if (!options_.json) std::fprintf(stderr, "%s\n", what->pipeline.pasted().c_str());
    size_t pictures = 0;
    ProgressBar bar(folder_.pictures(), "pictures");
    bar_ = &bar;
    for (size_t s = 0; s < folder_.sequences.size(); ++s) {
      const LabelledSequence& sequence = folder_.sequences[s];
      const RunHandlers handlers{.accept =
                                     [&](size_t i, const DecodedPicture& picture) {
                                       return (*evaluator)->accept(sequence.pictures[i], picture);
                                     },
                                 .results =
                                     [&](size_t i, const Json& frame) {
                                       ++pictures;
                                       return (*evaluator)->add(s, sequence.pictures[i], frame);
                                     },
                                 .progress = [&] { bar.step(); },
                                 .warn = [&](const Error& warning) { warn(warning); }};
      if (auto status = play_pictures(what->pipeline, sequence, handlers); !status) return status;
    }
    bar.clear();
    bar_ = nullptr;
    if (pictures == 0)
      return Error{.code = Code::LABELS_INVALID,
                   .what = "no picture of the folder can be used",
                   .offered = options_.folder,
                   .needed = "pictures that fit their truth",
                   .fix = "correct what the warnings above report"};
    auto evaluation = (*evaluator)->finish();
    if (!evaluation) return evaluation.error();
    for (const Error& warning : (*evaluator)->warnings()) warn(warning);
    out_.pictures = pictures;
    out_.evaluated.push_back({what->name, what->pipeline.pasted(), *std::move(evaluation), {}});
    return ok();
  }

 private:
  // Each warning once: both pipelines have those of the folder's files.
  void warn(const Error& warning) {
    for (const Error& other : out_.warnings)
      if (other.message() == warning.message()) return;
    out_.warnings.push_back(warning);
    if (bar_) bar_->clear();
    if (!options_.json) std::fprintf(stderr, "warning: %s\n", warning.message().c_str());
  }

  const EvaluateOptions& options_;
  const LabelledFolder& folder_;
  EvaluationComparison& out_;
  ProgressBar* bar_ = nullptr;
};

Error cannot_write(const std::string& file) {
  return {.code = Code::FILE_NOT_WRITTEN,
          .what = "the page cannot be written",
          .offered = file,
          .needed = "a path in a folder that can be written to",
          .fix = "--page evaluation.html"};
}

}  // namespace

int evaluate(const EvaluateOptions& options) {
  const auto folder = read_labelled_folder(options);
  if (!folder) return report(folder.error(), options.json);
  // Before minutes of work: an existing page is replaced only at the end.
  if (!options.page.empty() && !std::ofstream(options.page, std::ios::app))
    return report(cannot_write(options.page), options.json);
  EvaluationComparison comparison{
      .folder = options.folder, .draws = options.draws, .seed = options.seed};
  Evaluating evaluating(options, *folder, &comparison);
  if (auto status = evaluating.run(options.model); !status)
    return report(status.error(), options.json);
  if (!options.compare.empty())
    if (auto status = evaluating.run(options.compare); !status)
      return report(status.error(), options.json);
  add_intervals(&comparison);
  if (options.json)
    print(to_json(comparison));
  else
    std::fputs(("\n" + to_text(comparison)).c_str(), stdout);
  if (options.page.empty()) return kExitGood;
  std::ofstream page(options.page);
  page << evaluation_page(comparison);
  page.close();
  if (!page) return report(cannot_write(options.page), options.json);
  if (!options.json) std::printf("\nPage: %s\n", options.page.c_str());
  return kExitGood;
}

}  // namespace weir::app
