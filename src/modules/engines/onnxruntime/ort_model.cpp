// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_model.hpp"

#include <algorithm>
#include <optional>

#include "lowering/lowered_model_info.hpp"
#include "model_bytes.hpp"
#include "model_source.hpp"
#include "onnxruntime/ort_metadata.hpp"
#include "onnxruntime/ort_types.hpp"
#include "tflite-file/tflite_file.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

bool mentions(const std::string& text, std::initializer_list<const char*> phrases) {
  return std::any_of(phrases.begin(), phrases.end(),
                     [&](const char* word) { return text.find(word) != std::string::npos; });
}

// ONNX Runtime's codes are ambiguous (an unknown operator is INVALID_GRAPH or FAIL), so its
// message, which names the operator, is evaluated too.
Error load_error(const OrtFailure& failure, const std::string& model) {
  if (is_out_of_memory(failure))
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "ONNX Runtime has no memory or threads to load the model",
                 .offered = model + ": " + failure.text,
                 .needed = {},
                 .difference = {},
                 .fix = "custom=NumThreads:1"};
  const bool unsupported =
      failure.code == ORT_NOT_IMPLEMENTED ||
      mentions(failure.text, {"is not a registered function/op", "Could not find an implementation",
                              "Unsupported model IR version", "is under development",
                              "No Op registered", "Opset"});
  Error error{.code = Code::MODEL_INVALID,
              .what = "ONNX Runtime cannot load the model",
              .offered = model,
              .needed = failure.text};
  if (unsupported) {
    error.code = Code::MODEL_UNSUPPORTED;
    error.what = "the model needs something that this ONNX Runtime lacks";
    error.fix = "export the model with an older opset or with standard operators only";
  } else {
    error.fix = "download or export the model again, then check it with weir inspect MODEL";
  }
  return Error{.code = error.code,
               .what = error.what,
               .offered = model + ": " + failure.text,
               .fix = error.fix};
}

template <class T, class Create, class Release>
Result<OrtOwner<T>> make(const OrtApi& api, Release release, Create create) {
  T* raw = nullptr;
  if (auto bad = take(api, create(&raw)))
    return Error{
        .code = Code::INTERNAL, .what = "ONNX Runtime rejected a call", .offered = bad.text};
  return OrtOwner<T>(raw, release);
}

Error unsupported_port(const std::string& name, const std::string& offered) {
  return unsupported_type("the model's tensor " + name, offered,
                          "export the model without it, or convert it within the model (Cast)");
}

}  // namespace

OrtModel::OrtModel(std::shared_ptr<const OrtRuntime> runtime)
    : runtime_(std::move(runtime)),
      arena_(OrtArena::shared(runtime_)),
      session_(nullptr, runtime_->api().ReleaseSession) {}

namespace {

bool is_tflite(std::span<const std::byte> bytes) {
  return tflite_score({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}) > 0;
}

Status check_head(std::span<const std::byte> head) {
  return is_tflite(head) ? ok() : check_onnx_head(head);
}

// Properties of a lowered model from its source file.
struct LoweredFacts {
  std::vector<PortQuantization> inputs, outputs;
  std::string metadata;
};

// Replaces a TensorFlow Lite model with the lowered ONNX model, which is then opened. Nullopt: it
// is another model.
Result<std::optional<LoweredFacts>> lower(ModelBytes* file, OrtOptions* options) {
  if (!is_tflite(file->bytes)) return std::optional<LoweredFacts>();
  auto lowered = lower_tflite(file->bytes);
  if (!lowered) {
    Error error = lowered.error();
    error.offered = file->name() + (error.offered.empty() ? "" : ": " + error.offered);
    if (error.code == Code::MODEL_UNSUPPORTED) error.fix = "framework=tensorflow-lite";
    return error;
  }
  LoweredFacts facts{std::move(lowered->inputs), std::move(lowered->outputs),
                     lowered_metadata(file->bytes)};
  const auto* bytes = reinterpret_cast<const std::byte*>(lowered->onnx.data());
  file->owned.assign(bytes, bytes + lowered->onnx.size());
  file->bytes = file->owned;
  file->path.clear();
  // ONNX Runtime must not requantise what the lowered graph computes in floats.
  options->config.insert_or_assign("session.disable_quant_qdq", std::string("1"));
  return std::optional(std::move(facts));
}

// ONNX Runtime opens the file itself if weights may be in other files next to it, or if a copy
// would cost too much memory. Otherwise it reads the bytes that were checked.
bool should_open_path(const ModelBytes& file, const OnnxSummary& summary) {
  return !file.path.empty() &&
         (summary.may_need_other_files || file.owned.size() > ModelSource::kKeptBytes);
}

}  // namespace

Result<std::unique_ptr<OrtModel>> OrtModel::open(const weir_open& request) {
  auto runtime = OrtRuntime::instance();
  if (!runtime) return runtime.error();
  auto options = OrtOptions::read(request, (*runtime)->version());
  if (!options) return options.error();
  auto file = read_model(request, {.check_head = check_head});
  if (!file) return file.error();
  auto lowered = lower(&*file, &*options);
  if (!lowered) return lowered.error();
  auto summary = read_onnx(file->bytes);
  if (!summary) {
    Error error = summary.error();
    error.offered = file->name() + ": " + error.offered;
    return error;
  }
  if (options->by_size && summary->is_small()) options->threads = 1;
  std::unique_ptr<OrtModel> model(new OrtModel(*runtime));
  if (auto status = model->take_own_operators(*options, *summary, &*file); !status)
    return status.error();
  if (!model->own_ && should_open_path(*file, *summary)) file->owned = {};
  if (auto status = model->create_session(*file, *options); !status) return status.error();
  model->threads_ = options->threads;
  model->spins_ = options->spins && options->threads > 1;
  if (auto status = model->read_session(*summary); !status) return status.error();
  if (auto& source = *lowered) {
    lay_over(source->inputs, model->inputs_.infos);
    lay_over(source->outputs, model->outputs_.infos);
    model->metadata_ = std::move(source->metadata);
  } else {
    model->metadata_ = ort_metadata_json(**runtime, model->session(), *summary);
  }
  return model;
}

Status OrtModel::read_session(const OnnxSummary& summary) {
  auto inputs = read_ports(true, summary), outputs = read_ports(false, summary);
  if (!inputs) return inputs.error();
  if (!outputs) return outputs.error();
  inputs_ = *std::move(inputs);
  outputs_ = *std::move(outputs);
  mark_batch_axis();
  shapes_depend_on_data_ = summary.shapes_depend_on_data();
  weight_bytes_ = summary.weight_bytes;
  return ok();
}

Status OrtModel::take_own_operators(const OrtOptions& options, const OnnxSummary& summary,
                                    ModelBytes* file) {
  if (options.optimization != ORT_ENABLE_ALL || !summary.operators.contains("PRelu")) return ok();
  auto changed = with_own_prelu(file->bytes);
  if (!changed) return ok();
  auto own = OwnOperators::shared(runtime_);
  if (!own) return own.error();
  own_ = *std::move(own);
  file->owned = *std::move(changed);
  file->bytes = file->owned;
  return ok();
}

Status OrtModel::create_session(const ModelBytes& file, const OrtOptions& options) {
  const OrtApi& api = runtime_->api();
  auto settings = make<OrtSessionOptions>(api, api.ReleaseSessionOptions, api.CreateSessionOptions);
  if (!settings) return settings.error();
  const auto refused = [](const OrtFailure& bad, const std::string& option) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = "ONNX Runtime rejects an option",
                 .offered = option,
                 .needed = bad.text};
  };
  if (auto bad = take(api, api.SetIntraOpNumThreads(settings->get(), options.threads)))
    return refused(bad, "NumThreads:" + std::to_string(options.threads));
  if (auto bad =
          take(api, api.SetSessionGraphOptimizationLevel(settings->get(), options.optimization)))
    return refused(bad, "GraphOptimization");
  for (const auto& [key, value] : options.config)
    if (auto bad =
            take(api, api.AddSessionConfigEntry(settings->get(), key.c_str(), value.c_str())))
      return refused(bad, key + ":" + value);
  if (own_)
    if (auto bad = take(api, api.AddCustomOpDomain(settings->get(), own_->domain())))
      return Error{.code = Code::INTERNAL,
                   .what = "ONNX Runtime rejects an operator of Weir",
                   .offered = bad.text};
  const FoldedWarnings folded;
  OrtSession* session = nullptr;
  const bool by_path = !file.path.empty() && file.owned.empty();
  OrtStatus* status = !by_path
                          ? api.CreateSessionFromArray(runtime_->environment(), file.bytes.data(),
                                                       file.bytes.size(), settings->get(), &session)
                          : api.CreateSession(runtime_->environment(), file.path.c_str(),
                                              settings->get(), &session);
  if (auto bad = take(api, status)) return load_error(bad, file.name());
  session_.reset(session);
  return ok();
}

Result<OrtPorts> OrtModel::read_ports(bool inputs, const OnnxSummary& summary) const {
  const OrtApi& api = runtime_->api();
  size_t count = 0;
  take(api, inputs ? api.SessionGetInputCount(session(), &count)
                   : api.SessionGetOutputCount(session(), &count));
  OrtPorts ports;
  ports.names.reserve(count);  // the names in infos point into these strings
  for (size_t i = 0; i < count; ++i) {
    OrtAllocator* allocator = runtime_->allocator();
    char* name = nullptr;
    if (auto bad = take(api, inputs ? api.SessionGetInputName(session(), i, allocator, &name)
                                    : api.SessionGetOutputName(session(), i, allocator, &name)))
      return Error{.code = Code::INTERNAL,
                   .what = "ONNX Runtime returns no name for a tensor",
                   .offered = bad.text};
    ports.names.emplace_back(name);
    take(api, api.AllocatorFree(allocator, name));
    auto type = make<OrtTypeInfo>(api, api.ReleaseTypeInfo, [&](OrtTypeInfo** out) {
      return inputs ? api.SessionGetInputTypeInfo(session(), i, out)
                    : api.SessionGetOutputTypeInfo(session(), i, out);
    });
    if (!type) return type.error();
    if (auto status = read_port(**type, summary, &ports); !status) return status.error();
  }
  for (size_t i = 0; i < count; ++i) {
    ports.infos[i].name = ports.names[i].c_str();
    ports.name_pointers.push_back(ports.names[i].c_str());
  }
  return ports;
}

Status OrtModel::read_port(const OrtTypeInfo& type, const OnnxSummary& summary,
                           OrtPorts* ports) const {
  const OrtApi& api = runtime_->api();
  const std::string& name = ports->names.back();
  ONNXType kind = ONNX_TYPE_UNKNOWN;
  take(api, api.GetOnnxTypeFromTypeInfo(&type, &kind));
  const OrtTensorTypeAndShapeInfo* tensor = nullptr;  // owned by `type`
  if (kind == ONNX_TYPE_TENSOR) take(api, api.CastTypeInfoToTensorInfo(&type, &tensor));
  if (!tensor) return unsupported_port(name, "a sequence, map or optional value, not a tensor");
  ONNXTensorElementDataType element = ONNX_TENSOR_ELEMENT_DATA_TYPE_UNDEFINED;
  take(api, api.GetTensorElementType(tensor, &element));
  const auto known = from_ort(element);
  if (!known)
    return unsupported_port(name, std::string("elements of type ") + ort_type_name(element));
  weir_tensor_info info = open_tensor_info();
  info.type = *known;
  std::vector<std::string> symbols;
  if (auto status = read_shape(*tensor, summary.shapeless.contains(name), &info, &symbols); !status)
    return status;
  ports->infos.push_back(info);
  ports->types.push_back(element);
  ports->symbols.push_back(std::move(symbols));
  return ok();
}

Status OrtModel::read_shape(const OrtTensorTypeAndShapeInfo& tensor, bool shapeless,
                            weir_tensor_info* info, std::vector<std::string>* symbols) const {
  const OrtApi& api = runtime_->api();
  size_t rank = 0;
  take(api, api.GetDimensionsCount(&tensor, &rank));
  if (rank > WEIR_RANK_LIMIT)
    return unsupported_rank("a tensor of the model", static_cast<long long>(rank));
  // ONNX Runtime reports rank 0 for scalars and for tensors without a shape.
  info->rank = rank == 0 && shapeless ? WEIR_RANK_UNKNOWN : static_cast<uint32_t>(rank);
  if (rank == 0) return ok();
  std::vector<const char*> names(rank, "");
  take(api, api.GetDimensions(&tensor, info->shape, rank));
  take(api, api.GetSymbolicDimensions(&tensor, names.data(), rank));
  for (size_t i = 0; i < rank; ++i) {
    if (info->shape[i] < 0) info->shape[i] = -1;
    symbols->emplace_back(names[i] ? names[i] : "");
  }
  return ok();
}

// The first axis is the batch if it is open, with the same name, in every input and output.
void OrtModel::mark_batch_axis() {
  std::string name;
  for (const auto* ports : {&inputs_, &outputs_})
    for (size_t i = 0; i < ports->infos.size(); ++i) {
      const auto& info = ports->infos[i];
      if (info.rank == 0 || info.rank == WEIR_RANK_UNKNOWN || info.shape[0] != -1) return;
      const std::string& symbol = ports->symbols[i][0];
      if (symbol.empty() || (!name.empty() && symbol != name)) return;
      name = symbol;
    }
  for (auto* ports : {&inputs_, &outputs_})
    for (auto& info : ports->infos) info.batch_axis = 0;
}

void OrtModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_FORK_UNSAFE;  // its threads do not survive a fork
  if (shapes_depend_on_data_)
    info->flags |= WEIR_MODEL_DYNAMIC_OUTPUT | WEIR_MODEL_ALLOCATES_OUTPUT;
  info->n_inputs = static_cast<uint32_t>(inputs_.infos.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.infos.size());
  info->inputs = inputs_.infos.data();
  info->outputs = outputs_.infos.data();
  info->alignment = info->input_padding = 0;  // the kernels accept any address
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = 0;  // no limit
  info->max_in_flight = 1;
  info->preferred_batch = 1;
  info->weight_bytes = weight_bytes_;
  info->metadata_json = metadata_.c_str();
}

}  // namespace weir::engine
