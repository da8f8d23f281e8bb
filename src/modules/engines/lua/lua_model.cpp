// Loads a script, runs it once and reads its tensor tables.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "lua/lua_model.hpp"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "model_bytes.hpp"
#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxSource = uint64_t{64} << 20;
constexpr char kSourceName[] = "model";  // appears in messages: "model:3: ..."

struct Source {
  std::string text, name;
  std::string folder = {};  // of the file, absolute; "" if the text is no file
};

// Joins model= at its commas again; only blanks next to commas are lost.
std::string joined(const weir_open& request) {
  return join(std::span(request.paths, request.paths ? request.n_models : 0), ",", text_or_empty);
}

// A script assigns tables, so a text without an assignment was meant as a file name.
bool looks_like_a_path(const std::string& text) {
  return text.find('=') == std::string::npos && text.find('\n') == std::string::npos;
}

Result<Source> read_source(const weir_open& request) {
  const std::string text = joined(request);
  std::error_code failed;
  const bool file = request.n_models == 1 && fs::exists(text, failed);
  if (!file && request.n_models > 0) {
    if (looks_like_a_path(text))
      return Error{.code = Code::MODEL_NOT_FOUND,
                   .what = "the script does not exist",
                   .offered = text,
                   .needed = "a file with Lua's source text, or the text itself",
                   .fix = "model=/path/to/script.lua"};
    return Source{text, kSourceName};
  }
  const auto model = read_model(request, {.max = kMaxSource});
  if (!model) return model.error();
  const auto* bytes = reinterpret_cast<const char*>(model->bytes.data());
  Source out{{bytes, model->bytes.size()},
             model->path.empty() ? std::string(kSourceName) : model->path};
  std::error_code ignored;
  if (!model->path.empty())
    out.folder = fs::absolute(model->path, ignored).parent_path().lexically_normal().string();
  return out;
}

bool same_tensors(const std::vector<weir_tensor_info>& a, const std::vector<weir_tensor_info>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.type == y.type && x.rank == y.rank && std::equal(x.shape, x.shape + x.rank, y.shape);
  });
}

}  // namespace

Result<std::unique_ptr<LuaModel>> LuaModel::open(const weir_open& request) {
  const auto api = LuaApi::instance();
  if (!api) return api.error();
  const auto options = LuaOptions::read(request);
  if (!options) return options.error();
  auto source = read_source(request);
  if (!source) return source.error();
  std::unique_ptr<LuaModel> model(new LuaModel(**api));
  model->options_ = *options;
  model->text_ = std::move(source->text);
  model->name_ = std::move(source->name);
  model->folder_ = std::move(source->folder);
  auto state = model->new_state(&model->tensors_);
  if (!state) return state.error();
  model->state_bytes_ = (*state)->bytes();
  model->first_ = *std::move(state);
  model->metadata_ = nlohmann::json{{"language", "Lua"},
                                    {"sandbox", model->options_.sandbox},
                                    {"libraries", model->options_.libraries}}
                         .dump();
  return model;
}

Result<std::unique_ptr<LuaState>> LuaModel::new_state(ScriptTensors* tensors) const {
  auto state = LuaState::create(api_, options_);
  if (!state) return state.error();
  if (auto status = (*state)->search_in(folder_); !status) return status.error();
  if (auto status = (*state)->run(text_, name_); !status) return status.error();
  auto described = (*state)->describe();
  if (!described) {
    Error error = described.error();
    error.offered = name_ + ": " + error.offered;
    return error;
  }
  *tensors = *std::move(described);
  return state;
}

Result<std::unique_ptr<LuaState>> LuaModel::state() const {
  {
    const std::lock_guard lock(mutex_);
    if (first_) return std::move(first_);
  }
  ScriptTensors tensors;
  auto out = new_state(&tensors);
  if (!out) return out.error();
  if (!same_tensors(tensors.inputs, inputs()) || !same_tensors(tensors.outputs, outputs()))
    return Error{
        .code = Code::MODEL_INVALID,
        .what = "the script declares different tensors each time it runs",
        .offered = engine::describe(tensors.inputs) + " -> " + engine::describe(tensors.outputs),
        .needed = engine::describe(inputs()) + " -> " + engine::describe(outputs())};
  return out;
}

void LuaModel::describe(weir_model_info* info) const {
  info->n_inputs = static_cast<uint32_t>(inputs().size());
  info->n_outputs = static_cast<uint32_t>(outputs().size());
  info->inputs = inputs().data();
  info->outputs = outputs().data();
  info->alignment = sizeof(double);
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = 0;  // no limit
  info->max_in_flight = info->preferred_batch = 1;
  info->weight_bytes = state_bytes_;
  info->metadata_json = metadata_.c_str();
}

int lua_score(const std::string& path, std::span<const unsigned char> head) {
  constexpr int kByName = 80, kByTable = 60;
  if (path.ends_with(".lua")) return kByName;
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  return text.find("inputTensorsInfo") == text.npos ? 0 : kByTable;
}

}  // namespace weir::engine
