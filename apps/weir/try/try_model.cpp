// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/try_model.hpp"

#include <glib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "core/card/card.hpp"
#include "core/card/find_card.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/heads/families.hpp"
#include "core/heads/output_shapes.hpp"
#include "core/heads/readings.hpp"
#include "core/heads/usual_input.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/model_file.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/model_tensor.hpp"
#include "core/text/shell_quote.hpp"
#include "gstcpp/element/file_digest.hpp"
#include "inspect/command_error.hpp"
#include "inspect/model_card.hpp"
#include "models/catalogue.hpp"
#include "try/sized_tensors.hpp"
#include "weir/join.hpp"
#include "weir/label_file.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// The error of a model file that is not there, with a command as its fix: for a file with a similar
// name, or for the model of the catalogue that has such a file.
Error missing_file(const TryOptions& options, Error error) {
  std::error_code ignored;
  if (error.code != Code::MODEL_NOT_FOUND || fs::exists(options.model, ignored)) return error;
  const std::string input = " " + shell_word(options.input);
  if (const auto similar = infer::similar_model_file(options.model); !similar.empty()) {
    error.fix = "weir try " + shell_word(similar) + input;
    return error;
  }
  const auto all = read_catalogue();
  if (!all) return error;
  const auto name = fs::path(options.model).filename();
  const auto known = std::find_if(all->begin(), all->end(), [&name](const CatalogueModel& model) {
    return model.files[0].name == name || model.name == name.stem();
  });
  error.needed = "a file that can be read, or a name that weir models list prints";
  if (known == all->end()) return error;
  error.fix =
      is_fetched(*known) ? "weir try " + known->name + input : "weir models get " + known->name;
  return error;
}

// The file of a path or of a name of the catalogue. A name without an extension that the catalogue
// lacks is an error with the nearest name.
Result<std::string> find_path(const std::string& model) {
  auto file = file_of_model(model);
  std::error_code ignored;
  const bool is_path = model.find('/') != std::string::npos || fs::path(model).has_extension() ||
                       fs::exists(model, ignored);
  if (!file || *file != model || is_path) return file;
  const auto all = read_catalogue();
  if (!all) return file;
  return find_model(*all, model).error();
}

Result<std::shared_ptr<infer::Model>> open(const std::string& path,
                                           const std::string& engine_name) {
  infer::OpenOptions request;
  request.paths = {path};
  auto& library = infer::ModuleLibrary::instance();
  const auto engine =
      engine_name.empty() ? library.engine_for_model(request.paths) : library.engine(engine_name);
  if (!engine) return engine.error();
  return infer::Model::open(**engine, request);
}

// `shape` of the first input, if a card says it.
decoders::StreamModel describe_model(const infer::Model& model, const std::string& path,
                                     const std::vector<int64_t>& shape) {
  const auto inputs = sized_inputs(model, shape);
  const auto outputs = sized_outputs(model, path, inputs);
  const weir_stream_model facts{.struct_size = sizeof facts,
                                .n_inputs = static_cast<uint32_t>(inputs.size()),
                                .n_outputs = static_cast<uint32_t>(outputs.size()),
                                .inputs = inputs.data(),
                                .outputs = outputs.data(),
                                .path = path.c_str(),
                                .metadata_json = model.info().metadata_json,
                                .card_labels = nullptr,
                                .n_card_labels = 0};
  decoders::StreamModel out;
  out.set(&facts);
  return out;
}

// The option that selects one of several readings.
std::string make_option(const heads::Reading& reading, const std::vector<heads::Reading>& all) {
  const bool is_only_one = std::count_if(all.begin(), all.end(), [&](const heads::Reading& other) {
                             return other.mode == reading.mode;
                           }) == 1;
  return is_only_one ? "--mode " + reading.mode : "--head " + std::string(reading.family->name);
}

Error several(const std::vector<heads::Reading>& readings, const heads::ModelSignature& facts) {
  return {.code = Code::SPEC_MISMATCH,
          .what = "the outputs can be read as " + join(readings, " or as ",
                                                       [](const heads::Reading& r) {
                                                         return r.mode + " (" +
                                                                std::string(r.family->name) + ")";
                                                       }),
          .offered = facts.describe_outputs(),
          .needed = "the option that chooses one",
          .fix = join(readings, " or ",
                      [&](const heads::Reading& r) { return make_option(r, readings); })};
}

// The task of the user's mode.
Result<uint32_t> parse_task(const std::string& mode) {
  for (const auto& [name, task] : heads::kReadingModes)
    if (mode == name) return uint32_t{task};
  return Error{.code = Code::OPTION_VALUE,
               .what = "there is no such mode",
               .offered = "--mode " + mode,
               .needed = "one of: " +
                         join(heads::kReadingModes, ", ", [](const auto& m) { return m.first; }),
               .fix = "--mode detection"};
}

// Notes the readings of other heads, unless the chosen one is certain.
void note_others(const heads::Reading& chosen, const std::vector<heads::Reading>& readings,
                 const heads::ModelSignature& facts, std::vector<std::string>* notes) {
  std::vector<heads::Reading> others = readings;
  std::erase_if(others, [&](const heads::Reading& other) { return other.family == chosen.family; });
  if (others.empty() || chosen.family->fit(facts) == heads::Match::Certain) return;
  notes->push_back("also possible: " + join(others, ", ", [&](const heads::Reading& other) {
                     return make_option(other, readings);
                   }));
}

// The mode and family for the model's outputs. `mode` and `head` are the user's, or "".
Result<heads::Reading> find_reading(const heads::ModelSignature& facts, const std::string& mode,
                                    const std::string& head, std::vector<std::string>* notes) {
  const auto tasks = mode.empty() ? Result<uint32_t>(heads::stated_tasks(facts)) : parse_task(mode);
  if (!tasks) return tasks.error();
  if (!head.empty()) {
    const uint32_t allowed = mode.empty() ? ~0U : *tasks;
    const heads::Family* family = &heads::family_named(head, allowed, "--head ");
    for (const auto& [name, task] : heads::kReadingModes)
      if (family->tasks & allowed & task) return heads::Reading{name, family};
  }
  const auto readings = heads::list_readings(facts, *tasks);
  const auto best = heads::likely(readings, facts);
  if (best.size() > 1) return several(best, facts);
  if (best.empty()) {
    Error error = heads::nothing_fits(facts, *tasks, "--head ");
    if (mode.empty()) error.what = "no known head fits these outputs";
    return error;
  }
  note_others(best[0], readings, facts, notes);
  return best[0];
}

// A label file for names that do not lie in one: kept in the user's cache, so that the printed
// pipeline can be pasted later.
Result<std::string> kept_labels(const std::vector<std::string>& names, const std::string& model) {
  const fs::path folder = fs::path(g_get_user_cache_dir()) / "weir" / "labels";
  std::error_code failed;
  fs::create_directories(folder, failed);
  const fs::path path = folder / (fs::path(model).stem().string() + ".txt");
  std::ofstream file(path, std::ios::binary);
  for (const auto& name : names) file << name << '\n';
  file.close();
  if (!failed && file) return path.string();
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the labels cannot be stored",
               .offered = path.string(),
               .needed = "a folder that can be written to",
               .fix = "XDG_CACHE_HOME=/path/to/folder weir try ..."};
}

// The names that tensor_decoder finds without the property labels.
std::vector<std::string> found_labels(const decoders::StreamModel& model, const std::string& path) {
  if (const auto& names = model.labels(); !names.empty()) return names;
  const auto any = [](const card::ImageInput&) { return true; };
  return card::find_labels(
      path, any, [&path] { return gst::known_sha256(path); }, card::card_folders());
}

struct ModelLabels {
  std::string file;  // for the property labels; "" where it is not needed
  std::vector<std::string> names;
};

Result<ModelLabels> labels_of_user(const std::string& file) {
  try {
    return ModelLabels{file, read_label_file("--labels", file)};
  } catch (const Failure& failure) {
    return failure.error();
  }
}

Result<ModelLabels> read_labels(const TryOptions& options, const Result<card::Card>& card,
                                const decoders::StreamModel& model, const std::string& path) {
  if (!options.labels.empty()) return labels_of_user(options.labels);
  std::vector<std::string> names = model.labels();
  if (card) {
    const auto of_card = card::read_labels(*card, path, card::card_folders());
    if (of_card && !of_card->empty()) names = *of_card;
  }
  if (names.empty() || names == found_labels(model, path)) return ModelLabels{"", std::move(names)};
  auto file = kept_labels(names, path);
  if (!file) return file.error();
  return ModelLabels{*std::move(file), std::move(names)};
}

Error no_dictionary(const std::string& model) {
  return {.code = Code::LABELS_INVALID,
          .what = "text recognition needs the model's dictionary",
          .offered = model + " without --labels",
          .needed = "the dictionary file of the model, with one character on each line",
          .fix = "--labels /path/to/dictionary.txt"};
}

// How the card reads the outputs.
void decode_as_card(const card::Card& card, TryModel* out) {
  out->mode = card.decoder;
  out->decoder = card.decoder_options;
}

// How a head reads the outputs; its family's name.
Result<std::string> decode_by_head(const TryOptions& options, const std::string& mode,
                                   const decoders::StreamModel& facts, size_t labels,
                                   TryModel* out) {
  try {
    const auto described = facts.facts(std::span<const weir_tensor_info>(), {}, labels);
    const auto reading = find_reading(described, mode, options.head, &out->notes);
    if (!reading) return reading.error();
    out->mode = reading->mode;
    const std::string family(reading->family->name);
    if (labels == 0 && family == "ctc") return no_dictionary(out->path);
    if (!options.head.empty()) out->decoder.emplace_back("custom", "head:" + options.head);
    out->notes.push_back("read as " + out->mode + " by the head " + family);
    if (labels == 0 && out->mode != "text" && out->mode != "depth")
      out->notes.push_back("the classes have no names; set them with --labels FILE");
    return family;
  } catch (const Failure& failure) {
    return failure.error();
  }
}

// The samples of one frame of a model that takes a signal of float32 as a vector.
std::optional<int64_t> find_samples(const infer::Model& model) {
  constexpr int64_t kMin = 256;  // fewer are not the samples of a sound
  const auto& inputs = model.inputs();
  if (inputs.size() != 1 || inputs[0].type != WEIR_FLOAT32 || inputs[0].rank > WEIR_RANK_LIMIT)
    return std::nullopt;
  int64_t samples = 0;
  for (uint32_t i = 0; i < inputs[0].rank; ++i) {
    if (inputs[0].shape[i] == 1) continue;
    if (samples != 0) return std::nullopt;
    samples = inputs[0].shape[i];
  }
  return samples >= kMin ? std::optional(samples) : std::nullopt;
}

// `is_column`: each sample is a row of one value, as tensor_converter makes them.
std::string pipeline_for_sound(const TryOptions& options, const std::string& path, int64_t samples,
                               bool is_column, const std::string& mode) {
  return "gst-launch-1.0 -q " +
         PipelineDescription()
             .element("filesrc", {{"location", options.input}})
             .text(
                 " ! decodebin ! audioconvert ! audioresample ! "
                 "audio/x-raw,format=F32LE,rate=16000,channels=1 ! tensor_converter "
                 "frames-per-tensor=" +
                 std::to_string(samples) +
                 (is_column ? " ! " : " ! tensor_transform mode=transpose option=1:0:2:3 ! "))
             .element("tensor_filter", {{"model", path}})
             .text(" ! tensor_decoder mode=" + mode +
                   " max-results=1 ! tensor_decoder mode=json ! fdsink")
             .pasted();
}

// The error for a model that takes no picture, whose outputs are read in `mode`. The fix is a
// pipeline for models of sound, otherwise `weir inspect`.
Error takes_no_picture(const TryOptions& options, const std::string& path,
                       const infer::Model& model, const std::string& mode) {
  const auto samples = find_samples(model);
  const auto& inputs = model.inputs();
  const bool is_column = samples && inputs[0].shape[inputs[0].rank - 1] == 1;
  return {.code = Code::SPEC_MISMATCH,
          .what = inputs.size() > 1 ? "weir try runs models of one input"
                                    : "weir try runs models that take a picture",
          .offered = path + " takes " + list_tensors(model_tensors(model.inputs())),
          .needed = samples
                        ? "for sound, a pipeline as in docs/guide/classify-sound.md; it assumes "
                          "16000 samples a second, as most models of sound have"
                        : "for other data, a pipeline as in docs/guide/use-a-sensor.md",
          .fix = samples ? pipeline_for_sound(options, path, *samples, is_column, mode)
                         : "weir inspect " + shell_word(path)};
}

bool takes_picture(const infer::Model& model) {
  std::string ignored;
  const auto inputs = sized_inputs(model, {});
  return std::any_of(inputs.begin(), inputs.end(), [&](const auto& input) {
    return heads::usual_input("", input, &ignored).has_value();
  });
}

// How the outputs are read: by the card, else by a head. Returns the family of the head, "" for the
// card's.
Result<std::string> decode(const TryOptions& options, const Result<card::Card>& card,
                           const decoders::StreamModel& facts, size_t n_labels, TryModel* out) {
  const bool card_reads =
      card && !card->decoder.empty() && options.mode.empty() && options.head.empty();
  if (!card_reads || card->decoder == "image_labeling")
    return decode_by_head(options, card_reads ? "classification" : options.mode, facts, n_labels,
                          out);
  decode_as_card(*card, out);
  return std::string();
}

// The command without --mode, if the model can be read then; else "".
std::string propose_command(const TryOptions& options, const Result<card::Card>& card,
                            const decoders::StreamModel& facts, size_t n_labels, TryModel out) {
  TryOptions other = options;
  other.mode.clear();
  if (options.mode.empty() || !decode(other, card, facts, n_labels, &out)) return "";
  const auto option = [](const char* name, const std::string& value) {
    return value.empty() ? "" : name + shell_word(value);
  };
  return "weir try " + shell_word(options.model) + " " + shell_word(options.input) +
         option(" --head ", options.head) + option(" --labels ", options.labels) +
         option(" --engine ", options.engine);
}

Status check_input(const TryOptions& options, const std::string& path, const infer::Model& model) {
  if (!find_samples(model) && takes_picture(model)) return ok();
  return takes_no_picture(options, path, model,
                          options.mode.empty() ? "classification" : options.mode);
}

// How pixels are prepared: by the card, else as models of the family usually are.
Status prepare(const TryOptions& options, const Result<card::Card>& card, const infer::Model& model,
               const std::string& family, TryModel* out) {
  if (card) {
    if (card->path.empty()) out->input = card->inputs[0];
    out->preparation = card->path.empty() ? card::preprocess_properties(card->inputs[0])
                                          : Properties{{"card", card->path}};
    return ok();
  }
  std::string note;
  const auto inputs = sized_inputs(model, {});
  const auto pixels =
      inputs.size() == 1 ? heads::usual_input(family, inputs[0], &note) : std::nullopt;
  if (!pixels) return takes_no_picture(options, out->path, model, out->mode);
  out->input = pixels;
  out->preparation = card::preprocess_properties(*pixels);
  out->notes.push_back(note);
  return ok();
}

}  // namespace

Result<TryModel> try_model(const TryOptions& options) {
  const auto path = find_path(options.model);
  if (!path) return path.error();
  const auto model = open(*path, options.engine);
  if (!model) return missing_file(options, command_error(model.error()));
  TryOptions found = options;
  found.model = *path;
  return try_model(found, **model);
}

Result<TryModel> try_model(const TryOptions& options, const infer::Model& model) {
  TryModel out;
  out.path = options.model;
  out.engine = options.engine;
  const auto card = make_card(out.path, model);
  // Without its card the model would run on pixels that are guessed.
  if (!card && card.error().code == Code::CARD_INVALID) return card.error();
  const auto facts =
      describe_model(model, out.path, card ? card->inputs[0].shape : std::vector<int64_t>());
  if (auto status = card ? ok() : check_input(options, out.path, model); !status)
    return status.error();
  auto labels = read_labels(options, card, facts, out.path);
  if (!labels) return labels.error();
  out.labels = labels->file;
  out.names = std::move(labels->names);

  const auto family = decode(options, card, facts, out.names.size(), &out);
  if (!family) {
    Error error = family.error();
    if (error.fix.empty()) error.fix = propose_command(options, card, facts, out.names.size(), out);
    return error;
  }
  if (auto status = prepare(options, card, model, *family, &out); !status) return status.error();
  return out;
}

}  // namespace weir::app
