// `weir inspect MODEL`: what a model takes and gives, which engine runs it and why, and a line that
// runs it.
#include <cstdio>
#include <limits>
#include <memory>

#include "commands.hpp"
#include "core/infer/model.hpp"
#include "core/infer/module_library.hpp"
#include "core/text/text.hpp"
#include "engine_facts.hpp"
#include "launch_line.hpp"
#include "model_card.hpp"
#include "model_description.hpp"
#include "report.hpp"

namespace weir::app {
namespace {

struct Inspected {
  std::string model, framework;
  std::string reason;  // for the engine
  std::shared_ptr<infer::Model> opened;
};

bool automatic(const std::string& framework) {
  return framework.empty() || equal_ignoring_case(framework, "auto") ||
         equal_ignoring_case(framework, "any");
}

std::vector<std::string> paths_of(const std::string& model) {
  std::vector<std::string> out;
  for (const auto part : split(model, ","))
    if (!strip(part).empty()) out.emplace_back(strip(part));
  return out;
}

std::string reason_for(const std::vector<std::string>& paths) {
  const size_t dot = paths[0].rfind('.');
  if (paths.size() > 1 || dot == std::string::npos) return "by the names of the model's files";
  return "the file's name ends in " + paths[0].substr(dot);
}

Result<Inspected> open(const InspectOptions& options) {
  infer::OpenOptions request;
  request.paths = paths_of(options.model);
  if (request.paths.empty())
    return Error{Code::MODEL_NOT_FOUND,
                 "no model is named",
                 "\"" + options.model + "\"",
                 "the path of a model file",
                 "",
                 "weir inspect mobilenet.tflite"};
  Inspected out;
  out.model = options.model;
  auto& library = infer::ModuleLibrary::instance();
  const bool by_name = automatic(options.framework);
  out.reason = by_name ? reason_for(request.paths) : "--framework " + options.framework;
  if (!by_name) out.framework = options.framework;
  const auto engine =
      by_name ? library.engine_for_model(request.paths) : library.engine(options.framework);
  if (!engine) return engine.error();
  auto model = infer::Model::open(**engine, request);
  if (!model) return model.error();
  out.opened = *std::move(model);
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

// "(1, 224, 224, 3)" as NumPy prints shapes; ? where the model leaves it open.
std::string numpy_order(const weir_tensor_info& info) {
  if (info.rank == WEIR_RANK_UNKNOWN) return "?";
  std::string out;
  for (uint32_t i = 0; i < info.rank; ++i)
    out += (i ? ", " : "") + (info.shape[i] < 0 ? "?" : std::to_string(info.shape[i]));
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

Json to_json(const Inspected& found, const LaunchLine& line, const Result<card::Card>& card) {
  const auto& engine = found.opened->engine();
  Json out{{"model", found.model}};
  out["engine"] = {{"name", engine.name},
                   {"version", engine_version(engine)},
                   {"module", module_file(engine.name)},
                   {"reason", found.reason}};
  for (const char* side : {"inputs", "outputs"}) {
    out[side] = Json::array();
    for (const auto& info : *side == 'i' ? found.opened->inputs() : found.opened->outputs())
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

void print_card(const Result<card::Card>& card) {
  if (!card) {
    std::printf("\nCard\n  none: %s\n", card.error().what.c_str());
    return;
  }
  const std::string place = card->path.empty() ? "the model's own metadata" : card->path;
  std::printf("\nCard    %s: %s\n  to prepare video: %s\n", place.c_str(), card->task.c_str(),
              card::preparation(card->inputs[0]).c_str());
}

void print_text(const Inspected& found, const LaunchLine& line, const Result<card::Card>& card) {
  const auto& engine = found.opened->engine();
  std::printf("Model   %s\nEngine  %s %s: %s\n", found.model.c_str(), engine.name,
              engine_version(engine).c_str(), found.reason.c_str());
  print_tensors("Inputs", found.opened->inputs());
  print_tensors("Outputs", found.opened->outputs());
  print_card(card);
  std::fputs(description_text(model_description(*found.opened)).c_str(), stdout);
  std::printf("\nTo run it\n  %s\n", line.command.c_str());
  for (const auto& note : line.notes) std::printf("  note: %s\n", note.c_str());
}

}  // namespace

int inspect(const InspectOptions& options) {
  const auto found = open(options);
  if (!found) return report(found.error(), options.json);
  const auto card = card_of(found->model, *found->opened);
  const std::string preparation = card ? card::preparation(card->inputs[0]) : "";
  const auto line =
      launch_line(found->model, found->framework, found->opened->inputs(), preparation);
  if (options.json)
    print(to_json(*found, line, card));
  else
    print_text(*found, line, card);
  return kExitGood;
}

}  // namespace weir::app
