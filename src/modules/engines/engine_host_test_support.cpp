// Implements the test host.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_host_test_support.hpp"

#include <dlfcn.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <regex>
#include <sstream>

#include "tensor_check.hpp"
#include "weir/abi.h"
#include "weir/join.hpp"

namespace weir::engine_test {
namespace {

namespace fs = std::filesystem;

std::mutex log_mutex;  // guards log_lines
std::vector<std::string> log_lines;

std::string text(const char* part) {
  return part ? part : "";
}

int fail(weir_error* error, int code, const char* what, const char* offered, const char* needed,
         const char* difference, const char* fix) {
  if (error)
    error->error = Error{.code = static_cast<Code>(code),
                         .what = text(what),
                         .offered = text(offered),
                         .needed = text(needed),
                         .difference = text(difference),
                         .fix = text(fix)};
  return -code;
}
void log(int, const char* module, const char* line) {
  const std::lock_guard lock(log_mutex);
  log_lines.push_back(text(module) + ": " + text(line));
}
int allocate(void*, uint32_t, uint64_t bytes, uint32_t alignment, weir_tensor* out) {
  out->data = std::aligned_alloc(alignment, (bytes / alignment + 1) * alignment);
  out->bytes = out->capacity = bytes;
  out->owner = out->data;
  out->release = std::free;
  return out->data ? WEIR_OK : -WEIR_OUT_OF_MEMORY;
}
std::map<std::string, const weir_engine*> findable;
int find_engine(const char* name, const weir_engine** out, weir_error* error) {
  const auto found = findable.find(text(name));
  *out = found == findable.end() ? nullptr : found->second;
  return *out ? WEIR_OK
              : fail(error, WEIR_ENGINE_UNKNOWN, "no engine has this name", name, "", "", "");
}
const weir_engine_finder kFinder{sizeof(weir_engine_finder), find_engine};
bool holds_frames = false;
std::atomic<int> frames_held{0};

// The memory of a test stays valid anyway; what is held is counted.
int hold(const weir_frame*, void (**release)(void*), void** owner) {
  ++frames_held;
  *release = [](void*) { --frames_held; };
  *owner = &frames_held;
  return 0;
}
const weir_frame_holder kHolder{sizeof kHolder, hold};

const void* extension(const char* id) {
  if (text(id) == WEIR_HOLD_FRAME && holds_frames) return &kHolder;
  return text(id) == WEIR_FIND_ENGINE ? &kFinder : nullptr;
}

const weir_host kHost{sizeof(weir_host), WEIR_ABI_MAJOR, WEIR_ABI_MINOR, fail,    log,
                      allocate,          nullptr,        nullptr,        nullptr, extension};

Status to_status(int result, const weir_error& error) {
  if (result >= 0) return ok();
  if (static_cast<int>(error.error.code) != -result)
    return Error{.code = Code::INTERNAL,
                 .what = "the engine returned another code than it reported"};
  return error.error;
}

std::string data_folder() {
  if (const char* chosen = std::getenv("WEIR_DATA")) return chosen;
  return std::string(WEIR_SOURCE_DIR) + "/../shared";
}

}  // namespace

const weir_engine* load_module(const char* path) {
  void* handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    std::fprintf(stderr, "%s\n", dlerror());
    return nullptr;
  }
  using Entry = const weir_module* (*)(const weir_host*);
  const auto entry = reinterpret_cast<Entry>(dlsym(handle, "weir_module_entry"));
  const weir_module* module = entry ? entry(&kHost) : nullptr;
  return module && module->engines ? module->engines[0] : nullptr;
}

void let_find(const std::string& name, const weir_engine* engine) {
  findable.erase(name);
  if (engine) findable[name] = engine;
}

std::vector<std::string> take_log() {
  const std::lock_guard lock(log_mutex);
  return std::exchange(log_lines, {});
}

uint64_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

void let_hold_frames(bool holds) {
  holds_frames = holds;
}
int held_frames() {
  return frames_held;
}

std::string shared_file(const std::string& relative) {
  const fs::path path = fs::path(data_folder()) / relative;
  return fs::exists(path) ? path.string() : "";
}

std::vector<std::string> shared_files(const std::string& relative, const std::string& extension) {
  std::vector<std::string> out;
  std::error_code missing;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(data_folder()) / relative, missing))
    if (entry.is_regular_file() && entry.path().extension() == extension)
      out.push_back(entry.path().string());
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::byte> read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> chars{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::byte> out(chars.size());
  if (!chars.empty()) std::memcpy(out.data(), chars.data(), chars.size());
  return out;
}

std::vector<float> read_png(const std::string& path) {
  const std::string command = std::string("/usr/bin/python3 '") + WEIR_SOURCE_DIR +
                              "/src/modules/engines/read_png.py' '" + path + "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::vector<float> out;
  for (int value = 0; pipe && std::fscanf(pipe.get(), "%d", &value) == 1;)
    out.push_back(static_cast<float>(value));
  return out;
}

std::vector<std::vector<float>> read_csv(const std::string& path) {
  std::vector<std::vector<float>> out;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::vector<float> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stof(cell));
    out.push_back(row);
  }
  return out;
}

std::string ListedTensor::text(const std::map<std::string, int64_t>& sizes) const {
  std::string out = type + "[";
  for (size_t i = 0; i < shape.size(); ++i) {
    const bool open = std::isdigit(static_cast<unsigned char>(shape[i][0])) == 0;
    const auto size = sizes.find(shape[i]);
    out += (i > 0 ? ", " : "");
    out += !open ? shape[i] : std::to_string(size == sizes.end() ? -1 : size->second);
  }
  return out + "]";
}

namespace {

// Parses "NAME TYPE[1, n, 3] q(...); ..." and skips truncated entries.
std::vector<ListedTensor> listed_tensors(const std::string& text) {
  static const std::regex entry(R"((\S+) (u?int\d+|float\d+)\[([^\]]*)\])");
  static const std::regex extent(R"([^,\s]+)");
  std::vector<ListedTensor> out;
  for (std::sregex_iterator at(text.begin(), text.end(), entry), end; at != end; ++at) {
    const std::string shape = (*at)[3];
    ListedTensor tensor{(*at)[1], (*at)[2], {}};
    for (std::sregex_iterator d(shape.begin(), shape.end(), extent); d != end; ++d)
      tensor.shape.push_back(d->str());
    out.push_back(tensor);
  }
  return out;
}

}  // namespace

ListedModel listed_model(const std::string& relative) {
  std::ifstream manifest(shared_file("MANIFEST.md"));
  for (std::string line; std::getline(manifest, line);) {
    if (!line.starts_with("| " + relative + " ")) continue;
    const size_t in = line.find("| IN "), out = line.find("\\| OUT ");
    if (in == std::string::npos) return {};
    return {listed_tensors(line.substr(in, out == std::string::npos ? out : out - in)),
            out == std::string::npos
                ? std::vector<ListedTensor>{}
                : listed_tensors(line.substr(out, line.find(" | ", out) - out))};
  }
  return {};
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "weir-engine-XXXXXX").string();
  path_ = mkdtemp(pattern.data()) ? pattern : "";
}
TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}
std::string TemporaryFolder::write(const std::string& name,
                                   const std::vector<std::byte>& bytes) const {
  std::ofstream file(path(name), std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path(name);
}

TestTensor make_tensor(uint32_t type, const std::vector<int64_t>& shape, const void* data,
                       size_t bytes) {
  TestTensor out;
  out.info.type = type;
  out.info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), out.info.shape);
  out.info.batch_axis = WEIR_NO_BATCH_AXIS;
  out.bytes.resize(data ? bytes : engine::tensor_bytes(out.info).value_or(0));
  if (data && bytes > 0) std::memcpy(out.bytes.data(), data, bytes);
  return out;
}

std::vector<int64_t> to_shape(const weir_tensor_info& info) {
  if (info.rank > WEIR_RANK_LIMIT) return {};
  return {info.shape, info.shape + info.rank};
}

std::string to_string(const weir_tensor_info& info) {
  std::string out = engine::describe(info);
  out = out.substr(0, out.find(' ')) + "[";
  return out + join(to_shape(info), ", ", [](int64_t extent) { return std::to_string(extent); }) +
         "]";
}

Result<std::unique_ptr<OpenEngine>> OpenEngine::open(const weir_engine& engine,
                                                     const std::string& path,
                                                     const Options& options, int threads) {
  std::unique_ptr<OpenEngine> out(new OpenEngine(engine));
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : options) pairs.push_back({key.c_str(), value.c_str()});
  const char* paths[] = {path.c_str()};
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = 1;
  request.paths = paths;
  request.options = pairs.data();
  request.n_options = static_cast<uint32_t>(pairs.size());
  request.threads = threads;
  weir_error error;
  if (auto status = to_status(engine.open(&request, &out->model_, &error), error); !status)
    return status.error();
  out->info_.struct_size = sizeof out->info_;
  if (auto status = to_status(engine.info(out->model_, &out->info_, &error), error); !status)
    return status.error();
  const int result = engine.session_new(out->model_, nullptr, 0, &out->session_, &error);
  if (auto status = to_status(result, error); !status) return status.error();
  return out;
}

OpenEngine::~OpenEngine() {
  if (session_) engine_.session_free(session_);
  if (model_) engine_.close(model_);
}

Result<std::vector<weir_tensor_info>> OpenEngine::resolve(
    const std::vector<weir_tensor_info>& inputs) {
  auto out = outputs();
  weir_error error;
  const int result = engine_.resolve(session_, inputs.data(), static_cast<uint32_t>(inputs.size()),
                                     out.data(), static_cast<uint32_t>(out.size()), &error);
  if (auto status = to_status(result, error); !status) return status.error();
  return out;
}

Status OpenEngine::invoke(const weir_frame& in, weir_frame& out) {
  weir_error error;
  return to_status(engine_.invoke(session_, &in, &out, &error), error);
}

Status OpenEngine::control(int op) {
  weir_error error;
  return to_status(engine_.control(session_, op, nullptr, &error), error);
}

Result<std::vector<TestTensor>> OpenEngine::invoke(const std::vector<TestTensor>& inputs) {
  std::vector<weir_tensor_info> infos;
  std::vector<weir_tensor> in(inputs.size());
  for (size_t i = 0; i < inputs.size(); ++i) {
    infos.push_back(inputs[i].info);
    in[i].data = const_cast<std::byte*>(inputs[i].bytes.data());
    in[i].bytes = in[i].capacity = inputs[i].bytes.size();
    in[i].flags = WEIR_TENSOR_READONLY;
    in[i].info = inputs[i].info;
  }
  auto resolved = resolve(infos);
  if (!resolved) return resolved.error();
  std::vector<TestTensor> results(resolved->size());
  std::vector<weir_tensor> out(resolved->size());
  for (size_t i = 0; i < out.size(); ++i) {
    results[i].info = out[i].info = (*resolved)[i];
    const auto bytes = engine::tensor_bytes((*resolved)[i]);
    if (!bytes) continue;
    results[i].bytes.resize(*bytes);
    out[i].data = results[i].bytes.data();
    out[i].bytes = out[i].capacity = *bytes;
  }
  weir_frame in_frame{}, out_frame{};
  in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
  in_frame.n_tensors = static_cast<uint32_t>(in.size());
  in_frame.tensors = in.data();
  out_frame.n_tensors = static_cast<uint32_t>(out.size());
  out_frame.tensors = out.data();
  const Status status = invoke(in_frame, out_frame);
  engine_allocated_ = 0;
  for (size_t i = 0; i < out.size(); ++i) {
    if (!out[i].release) continue;
    ++engine_allocated_;
    results[i].info = out[i].info;
    const auto* data = static_cast<const std::byte*>(out[i].data);
    results[i].bytes.assign(data, data + out[i].bytes);
    out[i].release(out[i].owner);
  }
  if (!status) return status.error();
  return results;
}

OneToOne::OneToOne(const std::vector<int64_t>& shape, std::span<float> x) {
  in_frame.struct_size = out_frame.struct_size = sizeof in_frame;
  in_frame.n_tensors = out_frame.n_tensors = 1;
  in_frame.tensors = &in;
  out_frame.tensors = &out;
  in.info = make_tensor(WEIR_FLOAT32, shape).info;
  in.data = x.data();
  in.bytes = in.capacity = x.size_bytes();
}

OneToOne::OneToOne(const std::vector<int64_t>& shape, std::span<float> x,
                   const std::vector<int64_t>& out_shape, std::span<float> y)
    : OneToOne(shape, x) {
  out.info = make_tensor(WEIR_FLOAT32, out_shape).info;
  out.data = y.data();
  out.bytes = out.capacity = y.size_bytes();
}

Code OneToOne::get_code(OpenEngine& model) {
  const Status status = through(model);
  return status ? Code::INTERNAL : status.error().code;
}

std::vector<TestTensor> zero_inputs(const OpenEngine& model) {
  std::vector<TestTensor> out;
  for (const auto& info : model.inputs()) {
    auto shape = to_shape(info);
    for (auto& extent : shape) extent = extent < 0 ? 1 : extent;
    out.push_back(make_tensor(info.type, shape));
  }
  return out;
}

size_t argmax(const std::vector<float>& values) {
  return static_cast<size_t>(std::max_element(values.begin(), values.end()) - values.begin());
}

}  // namespace weir::engine_test
