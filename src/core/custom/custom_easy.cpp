// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/custom/custom_easy.hpp"

#include <algorithm>
#include <cstring>

#include "core/custom/filter_library.hpp"
#include "core/custom/filter_name.hpp"
#include "core/infer/module/host.hpp"
#include "core/infer/module/named_objects.hpp"
#include "core/process/process_object.hpp"
#include "core/tensor/model_tensor.hpp"
#include "core/text/text.hpp"
#include "weir/engine.hpp"
#include "weir/join.hpp"
#include "weir/module.hpp"

namespace weir::custom {
namespace {

using Filters = infer::NamedObjects<std::shared_ptr<NamedFilter>>;
Filters& filters() {
  static auto& all = process::object<Filters>("named-filters");
  return all;
}

Error refused(const std::string& name, const std::string& why, const std::string& needed) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "the filter " + name + " cannot be registered",
               .offered = why,
               .needed = needed};
}

bool open_extents(const weir_tensor_info& info) {
  return std::any_of(info.shape, info.shape + info.rank, [](int64_t n) { return n < 0; });
}
bool is_open(const weir_tensor_info& info) {
  return info.type == WEIR_TYPE_END || info.rank == WEIR_RANK_UNKNOWN || open_extents(info);
}

// Describes why `info` is not a valid tensor; "" if it is.
std::string find_fault(const weir_tensor_info& info) {
  if (info.type > WEIR_TYPE_END) return "type " + std::to_string(info.type);
  if (info.rank == WEIR_RANK_UNKNOWN) return "";
  if (info.rank > WEIR_RANK_LIMIT) return "rank " + std::to_string(info.rank);
  for (uint32_t i = 0; i < info.rank; ++i)
    if (info.shape[i] == 0 || info.shape[i] < -1 || info.shape[i] > UINT32_MAX)
      return "extent " + std::to_string(info.shape[i]) + " of axis " + std::to_string(i);
  if (!is_open(info) && !to_spec(model_tensor(info)).bytes()) return describe(info);
  return "";
}

constexpr char kTensorNeeded[] =
    "a type of weir_type, at most 16 axes, each above 0, or -1 if it depends on the stream";

Status check_tensors(const std::string& name, const char* role, const weir_tensor_info* infos,
                     uint32_t count) {
  if (count == 0 || count > WEIR_TENSOR_LIMIT || !infos)
    return refused(name, std::to_string(infos ? count : 0) + " " + role + "s", "1 to 256 of them");
  for (uint32_t i = 0; i < count; ++i)
    if (const auto fault = find_fault(infos[i]); !fault.empty())
      return refused(name, std::string(role) + " " + std::to_string(i) + " with " + fault,
                     kTensorNeeded);
  return ok();
}

Status check(const std::string& name, const weir_filter& filter) {
  if (!can_be_a_name(name)) return refused('"' + name + '"', "its name", kNameNeeded);
  if (filter.struct_size < sizeof filter)
    return refused(name, "struct_size " + std::to_string(filter.struct_size),
                   "at least " + std::to_string(sizeof filter));
  if (!filter.invoke) return refused(name, "no invoke", "the function that makes the outputs");
  if (auto s = check_tensors(name, "input", filter.inputs, filter.n_inputs); !s) return s;
  if (auto s = check_tensors(name, "output", filter.outputs, filter.n_outputs); !s) return s;
  const auto open = std::find_if(filter.outputs, filter.outputs + filter.n_outputs, is_open);
  if (open != filter.outputs + filter.n_outputs && !filter.resolve &&
      (filter.flags & WEIR_FILTER_DYNAMIC) == 0)
    return refused(
        name, "output " + std::to_string(open - filter.outputs) + " is open: " + describe(*open),
        "its whole shape, or resolve, or WEIR_FILTER_DYNAMIC");
  return ok();
}

constexpr char kName[] = "custom-easy";

std::string name_in(std::span<const char* const> paths) {
  if (paths.size() == 1) return paths[0];
  const std::string list = join(paths, ",");
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "framework=custom-easy needs exactly one filter name",
                 .offered = "model=" + list,
                 .needed = "the name under which it was registered",
                 .fix = "framework=custom-easy model=NAME"});
}

class CustomEasy {
 public:
  static constexpr uint64_t kFlags = WEIR_ENGINE_MODEL_IS_NO_FILE;

  explicit CustomEasy(const OpenRequest& request)
      : filter_(value_or_throw(find_filter(name_in(request.paths)))) {}

  std::span<const weir_tensor_info> inputs() const { return filter_->inputs(); }
  std::span<const weir_tensor_info> outputs() const { return filter_->outputs(); }
  void describe(weir_model_info& info) const {
    const uint32_t flags = filter_->flags();
    if (flags & WEIR_FILTER_DYNAMIC)
      info.flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
    if (flags & WEIR_FILTER_THREAD_SAFE) info.flags |= WEIR_MODEL_THREAD_SAFE;
    if (flags & WEIR_FILTER_STATEFUL) info.flags |= WEIR_MODEL_STATEFUL;
  }
  void resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
    value_or_throw(filter_->resolve(in, out));
  }
  bool invoke(const weir_frame& in, weir_frame& out) {
    return value_or_throw(filter_->invoke(in, out));
  }

 private:
  std::shared_ptr<NamedFilter> filter_;
};

}  // namespace

NamedFilter::NamedFilter(std::string name, const weir_filter& filter)
    : name_(std::move(name)),
      filter_(filter),
      inputs_(copy(filter.inputs, filter.n_inputs)),
      outputs_(copy(filter.outputs, filter.n_outputs)) {}

std::vector<weir_tensor_info> NamedFilter::copy(const weir_tensor_info* infos, uint32_t count) {
  std::vector<weir_tensor_info> out(infos, infos + count);
  for (auto& info : out)
    if (info.name) info.name = names_.emplace_back(info.name).c_str();
  return out;
}

Result<std::shared_ptr<NamedFilter>> NamedFilter::make(const std::string& name,
                                                       const weir_filter& filter) {
  if (auto status = check(name, filter); !status) return status.error();
  return std::shared_ptr<NamedFilter>(new NamedFilter(name, filter));
}

NamedFilter::~NamedFilter() {
  if (release_) release_(filter_.data);
}

std::unique_lock<std::mutex> NamedFilter::take_turn() {
  return flags() & WEIR_FILTER_THREAD_SAFE ? std::unique_lock<std::mutex>()
                                           : std::unique_lock(turn_);
}

template <class Body>
Result<int> NamedFilter::call(Body&& body) {
  // The turn comes first: a function that unregisters itself waits for calls inside the gate only.
  const auto lock = take_turn();
  const infer::CallGate::Visit visit(gate_);
  if (visit) return body();
  return Error{.code = Code::CALLBACK_UNKNOWN,
               .what = "the filter " + name_ + " is no longer registered",
               .offered = "a frame after it was unregistered",
               .needed = "a filter that stays registered, or one with a release function",
               .fix = "stop the pipeline before weir_filter_unregister(\"" + name_ + "\")"};
}

Error NamedFilter::failed(int result, weir_error* error) const {
  if (!error->set)
    return Error{
        .code = Code::CALLBACK_FAILED,
        .what = "the filter " + name_ + " failed without an error message",
        .offered = "it returned " + std::to_string(result),
        .needed =
            "0 for success, above 0 to drop the frame, or below 0 after host->fail with a message"};
  Error failure = infer::take_error(error, result, "");
  failure.what = "the filter " + name_ + " failed: " + failure.what;
  return failure;
}

Status NamedFilter::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  if (!filter_.resolve) return ok();
  weir_error error;
  const auto result = call([&] {
    return filter_.resolve(&infer::host(), in.data(), static_cast<uint32_t>(in.size()), out.data(),
                           static_cast<uint32_t>(out.size()), filter_.data, &error);
  });
  if (!result) return result.error();
  if (*result < 0) return failed(*result, &error);
  for (size_t i = 0; i < out.size(); ++i) {
    out[i].name = outputs_[i].name;
    if (const auto fault = find_fault(out[i]); !fault.empty())
      return Error{.code = Code::CALLBACK_FAILED,
                   .what = "the filter " + name_ + " declares an invalid tensor",
                   .offered = "output " + std::to_string(i) + " with " + fault,
                   .needed = kTensorNeeded};
  }
  return ok();
}

Result<bool> NamedFilter::invoke(const weir_frame& in, weir_frame& out) {
  weir_error error;
  const auto result =
      call([&] { return filter_.invoke(&infer::host(), &in, &out, filter_.data, &error); });
  if (!result) return result.error();
  if (*result < 0) return failed(*result, &error);
  return *result == 0;
}

Result<std::shared_ptr<NamedFilter>> find_filter(const std::string& name) {
  if (auto found = filters().find(name)) return *found;
  if (const auto library = library_of_filter(name); !library.empty()) {
    if (const auto opened = open_filter_library(library); !opened) return opened.error();
    if (auto found = filters().find(name)) return *found;
  }
  const auto names = filters().names();
  const std::string close = nearest(name, names);
  return Error{.code = Code::CALLBACK_UNKNOWN,
               .what = "no filter is registered under this name",
               .offered = "framework=custom-easy model=" + name,
               .needed = filters().one_of(),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = "weir_filter_register(\"" + name + "\", ...) before the pipeline starts"};
}

namespace {

Status add(const char* name, const weir_filter* filter) {
  const std::string text = name ? name : "";
  if (!filter) return refused(text, "no description", "a weir_filter");
  auto made = NamedFilter::make(text, *filter);
  if (!made) return made.error();
  if (!filters().add(text, *made)) return refused(text, "another filter has this name", kNameFree);
  (*made)->own(filter->release);
  return ok();
}

}  // namespace

const weir_engine& custom_easy_engine() {
  static const weir_engine kTable = [] {
    accept_host(&infer::host());
    return engine_table<CustomEasy>(kName, "1", "", "");
  }();
  return kTable;
}

Status check_invocation(const weir_engine& engine, const weir_model_info& info,
                        const std::string& model, bool invoke_dynamic) {
  if (std::strcmp(engine.name, kName) != 0) return ok();
  const bool dynamic = (info.flags & WEIR_MODEL_DYNAMIC_OUTPUT) != 0;
  if (dynamic == invoke_dynamic) return ok();
  const std::string line = "tensor_filter framework=custom-easy model=" + model;
  return Error{.code = Code::OPTION_VALUE,
               .what = dynamic ? "the filter " + model + " decides its sizes with each frame"
                               : "the filter " + model + " has outputs of fixed sizes",
               .offered = dynamic ? "invoke-dynamic=false" : "invoke-dynamic=true",
               .needed = dynamic ? "invoke-dynamic=true" : "invoke-dynamic=false",
               .fix = line + (dynamic ? " invoke-dynamic=true" : "")};
}

}  // namespace weir::custom

int weir_filter_register(const char* name, const weir_filter* filter, weir_error** error) {
  return weir::custom::to_return_code(error, [&] { return weir::custom::add(name, filter); });
}

int weir_filter_unregister(const char* name) {
  const auto removed = weir::custom::filters().remove(name ? name : "");
  if (!removed) return -WEIR_CALLBACK_UNKNOWN;
  (*removed)->unregistered();
  return WEIR_OK;
}
