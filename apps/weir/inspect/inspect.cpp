// `weir inspect MODEL`: prints a model's inputs and outputs, the engine that runs it and why, and a
// pipeline that runs it. Without a model: only the engine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <span>

#include "commands.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "doctor/engine_info.hpp"
#include "doctor/engine_options.hpp"
#include "inspect/command_error.hpp"
#include "inspect/launch_line.hpp"
#include "inspect/model_card.hpp"
#include "inspect/model_description.hpp"
#include "inspect/model_paths.hpp"
#include "inspect/synthetic_inputs.hpp"
#include "models/catalogue.hpp"
#include "report.hpp"
#include "weir/join.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

struct Inspected {
  std::string model, framework;
  std::string reason;               // for choosing the engine
  std::vector<std::string> others;  // other engines that could run it, if the file name decided
  const weir_engine* engine = nullptr;
  std::shared_ptr<infer::Model> opened;  // null: only the engine was named, and it needs a model
  std::vector<weir_tensor_info> inputs, outputs;  // with the user's values
};

bool automatic(const std::string& framework) {
  return framework.empty() || equal_ignoring_case(framework, "auto") ||
         equal_ignoring_case(framework, "any");
}

// A model may leave its tensors to the stream: its outputs are known only with its inputs.
Status read_tensors(const TensorOptions& tensors, Inspected* found) {
  found->inputs = found->opened->inputs();
  found->outputs = found->opened->outputs();
  if (tensors.input.empty()) return ok();
  auto inputs = inputs_of_frame(found->inputs, tensors);
  if (!inputs) return inputs.error();
  auto session = infer::Session::create(found->opened);
  if (!session) return session.error();
  auto outputs = (*session)->resolve(*inputs);
  if (!outputs) return outputs.error();
  for (size_t i = 0; i < found->outputs.size() && i < outputs->size(); ++i)
    if (!(*outputs)[i].name) (*outputs)[i].name = found->outputs[i].name;
  found->inputs = *std::move(inputs);
  found->outputs = *std::move(outputs);
  return ok();
}

// Tries the inputs that the pipeline chooses: "" if the model accepts them or leaves nothing open.
std::string refusal_of_chosen(const Inspected& found) {
  const auto session = infer::Session::create(found.opened);
  if (!session) return session.error().what;
  const auto outputs = (*session)->resolve(chosen_inputs(found.inputs));
  if (outputs) return "";
  const Error& error = outputs.error();
  return error.difference.empty() ? error.what : error.difference;
}

// Sizes can be guessed of some dimensions, but not of all: such a line would only fail.
void note_refusal(const std::string& refusal, const Inspected& found, LaunchLine* line) {
  line->notes.push_back("the model rejects the sizes in this line: " + refusal);
  const bool has_no_sizes =
      std::any_of(found.inputs.begin(), found.inputs.end(),
                  [](const weir_tensor_info& info) { return info.rank == WEIR_RANK_UNKNOWN; });
  if (!has_no_sizes) return;
  line->command.clear();
  line->notes = {
      "the file does not have the dimensions of its inputs; with those of your model, " +
      inspect_command(found.model, found.framework, "--input 3:224:224:1 --inputtype float32") +
      " prints a pipeline"};
}

LaunchLine make_line(const InspectOptions& options, const Inspected& found,
                     const Result<card::Card>& card) {
  std::string properties = property_text(options.tensors);
  if (!options.custom.empty())
    properties += (properties.empty() ? "custom=" : " custom=") + launch_value(options.custom);
  auto line = launch_line(found.model, found.framework, found.inputs,
                          card ? card::preparation(card->inputs[0]) : "", properties);
  const bool chose = std::any_of(found.inputs.begin(), found.inputs.end(), leaves_open);
  if (const auto refusal = chose ? refusal_of_chosen(found) : ""; !refusal.empty())
    note_refusal(refusal, found, &line);
  if (found.inputs.empty())
    line.notes.push_back(
        inspect_command(found.model, found.framework, "--input 3:224:224:1 --inputtype uint8") +
        " prints the outputs for such a stream");
  return line;
}

Result<Inspected> open(const InspectOptions& options) {
  infer::OpenOptions request;
  request.declared = options.tensors.pairs();
  request.options = custom_options(options.custom);
  request.paths = split_paths(options.model);
  const bool by_name = automatic(options.framework);
  if (request.paths.empty() && by_name)
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = "no model is named",
                 .offered = "\"" + options.model + "\"",
                 .needed = "the path of a model file; weir models list prints models to try",
                 .fix = "weir inspect /path/to/model"};
  Inspected out;
  out.model = options.model;
  auto& library = infer::ModuleLibrary::instance();
  out.reason = "--engine " + options.framework;
  if (!by_name) out.framework = options.framework;
  if (by_name) {
    auto choice = library.choose_engine(request.paths);
    if (!choice) return command_error(choice.error());
    out.reason = std::move(choice->reason);
    out.others = std::move(choice->others);
  }
  const auto engine =
      by_name ? library.engine_for_model(request.paths) : library.engine(options.framework);
  if (!engine) return command_error(engine.error());
  out.engine = *engine;
  if (request.paths.empty() && !(out.engine->flags & WEIR_ENGINE_NEEDS_NO_MODEL)) return out;
  auto model = infer::Model::open(**engine, request);
  if (!model) return command_error(model.error());
  out.opened = *std::move(model);
  if (auto status = read_tensors(options.tensors, &out); !status) return status.error();
  return out;
}

const char* layout_name(uint32_t layout) {
  switch (layout) {
    case WEIR_LAYOUT_NHWC:
      return "NHWC";
    case WEIR_LAYOUT_NCHW:
      return "NCHW";
    case WEIR_LAYOUT_NONE:
      return "none";
    default:
      return "";
  }
}

// A shape in NumPy's format, "(1, 224, 224, 3)"; ? for an open dimension.
std::string numpy_order(const weir_tensor_info& info) {
  if (info.rank == WEIR_RANK_UNKNOWN) return "?";
  const std::string out = join(std::span(info.shape, info.rank), ", ", [](int64_t extent) {
    return extent < 0 ? "?" : std::to_string(extent);
  });
  return "(" + out + (info.rank == 1 ? ",)" : ")");
}

std::string shortest(float value) {
  char text[48];
  for (int digits = 1; digits <= std::numeric_limits<float>::max_digits10; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, static_cast<double>(value));
    if (std::strtof(text, nullptr) == value) break;
  }
  return text;
}

std::string quantisation(const weir_tensor_info& info) {
  if (info.scale == 0) return "none";
  return shortest(info.scale) + " * (value - " + std::to_string(info.zero_point) + ")";
}

Json to_json(const weir_tensor_info& info) {
  Json out{{"name", info.name ? info.name : ""}, {"type", type_name(info)}};
  out["dimension"] = caps_order(info);
  out["shape"] = nullptr;
  if (info.rank != WEIR_RANK_UNKNOWN) {
    out["shape"] = Json::array();
    for (uint32_t i = 0; i < info.rank; ++i)
      out["shape"].push_back(info.shape[i] < 0 ? Json(nullptr) : Json(info.shape[i]));
  }
  out["layout"] = layout_name(info.layout);
  out["quantisation"] = nullptr;
  if (info.scale != 0)
    out["quantisation"] = {{"scale", std::stod(shortest(info.scale))},
                           {"zero_point", info.zero_point}};
  return out;
}

Json engine_json(const Inspected& found) {
  const auto& engine = *found.engine;
  return {{"name", engine.name},
          {"version", engine_version(engine)},
          {"module", module_file(engine.name)},
          {"reason", found.reason},
          {"others", found.others},
          {"options", to_json(engine_options(engine))}};
}

Json to_json(const Inspected& found, const LaunchLine& line, const Result<card::Card>& card) {
  Json out{{"model", found.model}};
  out["engine"] = engine_json(found);
  for (const char* side : {"inputs", "outputs"}) {
    out[side] = Json::array();
    for (const auto& info : *side == 'i' ? found.inputs : found.outputs)
      out[side].push_back(to_json(info));
  }
  out["card"] = card ? app::to_json(*card, found.model) : Json(nullptr);
  if (!card) out["no_card"] = app::to_json(card.error());
  out.update(model_description(*found.opened));
  out["launch"] = line.command;
  out["notes"] = line.notes;
  return out;
}

void print_tensors(const char* title, const std::vector<weir_tensor_info>& tensors) {
  if (tensors.empty()) {
    std::printf("\n%s\n  depend on the stream\n", title);
    return;
  }
  std::vector<std::vector<std::string>> rows{
      {"#", "name", "type", "in caps", "in NumPy", "layout", "real value"}};
  for (size_t i = 0; i < tensors.size(); ++i) {
    const auto& info = tensors[i];
    const std::string name = info.name && *info.name ? info.name : "-";
    const std::string layout = layout_name(info.layout);
    rows.push_back({std::to_string(i), name, type_name(info), caps_order(info), numpy_order(info),
                    layout.empty() ? "-" : layout,
                    info.scale == 0 ? "the value" : quantisation(info)});
  }
  std::printf("\n%s\n%s", title, table(rows, "  ").c_str());
}

// A card describes pictures: other models need none.
void print_card(const Result<card::Card>& card, const infer::Model& model) {
  if (!card && card.error().code != Code::CARD_MISSING) {
    std::printf("\nCard\n%s\n", card.error().message().c_str());
    return;
  }
  if (!card && !has_pictures(model)) return;
  if (!card) {
    std::printf("\nCard\n  none: %s; weir card prints one\n",
                printable_text(card.error().what).c_str());
    return;
  }
  const std::string place = card->path.empty() ? "the model's own metadata" : card->path;
  std::printf("\nCard    %s: %s\n  to prepare video: %s\n", printable_text(place).c_str(),
              printable_text(card->task).c_str(),
              printable_text(card::preparation(card->inputs[0])).c_str());
}

void print_engine(const Inspected& found) {
  std::printf("Engine  %s %s: %s\n", found.engine->name, engine_version(*found.engine).c_str(),
              printable_text(found.reason).c_str());
  for (const auto& other : found.others) std::printf("  or    --engine %s\n", other.c_str());
}

void print_text(const Inspected& found, const LaunchLine& line, const Result<card::Card>& card) {
  if (!found.model.empty()) std::printf("Model   %s\n", printable_text(found.model).c_str());
  print_engine(found);
  print_tensors("Inputs", found.inputs);
  print_tensors("Outputs", found.outputs);
  print_card(card, *found.opened);
  std::fputs(description_text(model_description(*found.opened)).c_str(), stdout);
  print_options(engine_options(*found.engine));
  std::printf("\nTo run it\n");
  if (!line.command.empty()) std::printf("  %s\n", printable_text(line.command).c_str());
  for (const auto& note : line.notes) std::printf("  note: %s\n", printable_text(note).c_str());
}

}  // namespace

int inspect(const InspectOptions& given) {
  InspectOptions options = given;
  const auto file = file_of_model(given.model);
  if (!file) return report(file.error(), given.json);
  options.model = *file;
  const auto found = open(options);
  if (!found) return report(found.error(), options.json);
  if (!found->opened) {
    if (options.json) {
      print(Json{{"engine", engine_json(*found)}});
    } else {
      print_engine(*found);
      print_options(engine_options(*found->engine));
    }
    return kExitGood;
  }
  const auto card = make_card(found->model, *found->opened);
  const auto line = make_line(options, *found, card);
  if (options.json)
    print(to_json(*found, line, card));
  else
    print_text(*found, line, card);
  return kExitGood;
}

}  // namespace weir::app
