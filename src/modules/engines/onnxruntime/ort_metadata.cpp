// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_metadata.hpp"

#include <limits>
#include <nlohmann/json.hpp>

namespace weir::engine {
namespace {

using nlohmann::json;

class MetadataReader {
 public:
  MetadataReader(const OrtRuntime& runtime, const OrtModelMetadata* metadata)
      : api_(runtime.api()), allocator_(runtime.allocator()), metadata_(metadata) {}

  using Getter = OrtStatus*(ORT_API_CALL*)(const OrtModelMetadata*, OrtAllocator*, char**);
  std::string text(Getter get) const {
    char* raw = nullptr;
    if (take(api_, get(metadata_, allocator_, &raw))) return {};
    return adopt(raw);
  }

  json custom() const {
    json out = json::object();
    char** keys = nullptr;
    int64_t count = 0;
    if (take(api_,
             api_.ModelMetadataGetCustomMetadataMapKeys(metadata_, allocator_, &keys, &count)))
      return out;
    for (int64_t i = 0; keys && i < count; ++i) {
      char* value = nullptr;
      const bool bad = bool(take(
          api_, api_.ModelMetadataLookupCustomMetadataMap(metadata_, allocator_, keys[i], &value)));
      out[keys[i]] = bad ? std::string() : adopt(value);
      adopt(keys[i]);
    }
    if (keys) take(api_, api_.AllocatorFree(allocator_, keys));
    return out;
  }

 private:
  std::string adopt(char* raw) const {
    std::string out = raw ? raw : "";
    if (raw) take(api_, api_.AllocatorFree(allocator_, raw));
    return out;
  }

  const OrtApi& api_;
  OrtAllocator* allocator_;
  const OrtModelMetadata* metadata_;
};

void put(json* out, const char* key, const std::string& text) {
  if (!text.empty()) (*out)[key] = text;
}

}  // namespace

std::string ort_metadata_json(const OrtRuntime& runtime, const OrtSession* session,
                              const OnnxSummary& summary) {
  const OrtApi& api = runtime.api();
  OrtModelMetadata* raw = nullptr;
  json out = json::object();
  put(&out, "producer_version", summary.producer_version);
  if (summary.ir_version > 0) out["ir_version"] = summary.ir_version;
  if (!summary.opsets.empty()) out["opset"] = summary.opsets;
  if (!take(api, api.SessionGetModelMetadata(session, &raw))) {
    const OrtOwner<OrtModelMetadata> metadata(raw, api.ReleaseModelMetadata);
    const MetadataReader reader(runtime, metadata.get());
    put(&out, "producer", reader.text(api.ModelMetadataGetProducerName));
    put(&out, "graph", reader.text(api.ModelMetadataGetGraphName));
    put(&out, "domain", reader.text(api.ModelMetadataGetDomain));
    put(&out, "description", reader.text(api.ModelMetadataGetDescription));
    constexpr int64_t kNone =
        std::numeric_limits<int64_t>::max();  // the library's value for "none"
    int64_t version = kNone;
    if (!take(api, api.ModelMetadataGetVersion(metadata.get(), &version)) && version != kNone)
      out["model_version"] = version;
    out["custom_metadata_map"] = reader.custom();
  }
  // Texts come from the file: replaces bytes that are not UTF-8 instead of failing.
  return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace weir::engine
