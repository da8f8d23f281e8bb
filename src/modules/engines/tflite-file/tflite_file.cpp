// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_file.hpp"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "tflite-file/flat_buffer.hpp"
#include "tflite-file/tflite_tensor.hpp"

namespace weir::engine {
namespace {

constexpr uint32_t kSchemaVersion = 3;

// Values of BuiltinOperator.
enum Operator : int32_t {
  kCustom = 32,
  kUnique = 103,
  kWhere = 109,
  kIf = 118,
  kWhile = 119,
  kCallOnce = 129,
  kVarHandle = 142,
  kReadVariable = 143,
  kAssignVariable = 144
};
// Values of the union BuiltinOptions, for tables that hold more than scalars.
enum Options : uint8_t {
  kConcatEmbeddingsOptions = 3,
  kCallOptions = 16,
  kReshapeOptions = 17,
  kSqueezeOptions = 30,
  kIfOptions = 92,
  kWhileOptions = 93,
  kCallOnceOptions = 103,
  kVarHandleOptions = 111,
  kBucketizeOptions = 115
};

class Walker {
 public:
  Walker(FlatFile* file, TfliteSummary* out) : file_(*file), out_(*out) {}

  Status model() {
    const FlatTable model = file_.root();
    if (model.scalar<uint32_t>(0, 0) != kSchemaVersion)
      return damage("the schema version is " + std::to_string(model.scalar<uint32_t>(0, 0)) +
                    ", not 3");
    out_.description = model.string(3).text();
    if (auto status = operator_codes(model.vector(1, 4)); !status) return status;
    if (auto status = buffers(model.vector(4, 4)); !status) return status;
    const FlatVector subgraphs = model.vector(2, 4);
    if (subgraphs.size() == 0) return damage("there is no graph in the file");
    out_.subgraphs = subgraphs.size();
    for (uint32_t i = 0; i < subgraphs.size(); ++i)
      if (auto status = subgraph(subgraphs.table(i), i); !status) return status;
    model.vector(5, 4);
    if (auto status = metadata(model.vector(6, 4)); !status) return status;
    if (auto status = signatures(model.vector(7, 4)); !status) return status;
    if (calls_itself()) return damage("a subgraph calls itself");
    return file_.damaged() ? damage("") : ok();
  }

 private:
  Status damage(const std::string& text) const { return tflite_damage(file_, text); }

  Status operator_codes(const FlatVector& codes) {
    for (uint32_t i = 0; i < codes.size() && !file_.damaged(); ++i) {
      const FlatTable code = codes.table(i);
      const int32_t number =
          std::max<int32_t>(code.scalar<int8_t>(0, 0), code.scalar<int32_t>(3, 0));
      const FlatVector name = code.string(1);
      if (number < 0) return damage("operator code " + std::to_string(number));
      if (number == kCustom && name.size() == 0) return damage("a custom operator without a name");
      codes_.push_back(number);
    }
    return file_.damaged() || codes_.empty() ? damage("there are no operators in the file") : ok();
  }

  Status buffers(const FlatVector& buffers) {
    for (uint32_t i = 0; i < buffers.size() && !file_.damaged(); ++i)
      buffers_.push_back(buffers.table(i).vector(0, 1));
    return file_.damaged() || buffers_.empty() ? damage("there are no buffers in the file") : ok();
  }

  Status subgraph(const FlatTable& graph, uint32_t index) {
    const FlatVector tensors = graph.vector(0, 4), operators = graph.vector(3, 4);
    const FlatVector inputs = graph.vector(1, 4), outputs = graph.vector(2, 4);
    graph.string(4);
    tensors_.clear();
    out_.tensors += tensors.size();
    out_.operators += operators.size();
    for (uint32_t i = 0; i < tensors.size(); ++i) {
      const auto tensor = check_tflite_tensor(&file_, tensors.table(i), buffers_);
      if (!tensor) return tensor.error();
      tensors_.push_back(*tensor);
      out_.has_state |= tensor->variable;
    }
    tensor_counts_.push_back(tensors.size());
    if (!indices_good(inputs, 0) || !indices_good(outputs, 0))
      return damage("an input or output of the graph names no tensor");
    if (index == 0 && outputs.size() == 0) return damage("the graph has no output");
    if (!make(inputs))
      return damage("two inputs of the graph are one tensor, or one is a constant");
    for (uint32_t i = 0; i < operators.size(); ++i)
      if (auto status = operation(operators.table(i), index); !status) return status;
    for (uint32_t i = 0; i < outputs.size(); ++i) {
      const auto tensor = outputs.scalar<int32_t>(i);
      if (!is_available(tensor)) return damage("no operator produces an output of the graph");
      out_.passes_through |= !tensors_[static_cast<size_t>(tensor)].computed;
    }
    return file_.damaged() ? damage("") : ok();
  }

  Status operation(const FlatTable& op, uint32_t graph) {
    const auto code = op.scalar<uint32_t>(0, 0);
    if (file_.damaged() || code >= codes_.size()) return damage("an operator of unknown kind");
    const FlatVector inputs = op.vector(1, 4), outputs = op.vector(2, 4), inner = op.vector(8, 4);
    op.vector(5, 1);
    op.vector(7, 1);
    if (!indices_good(inputs, -1) || !indices_good(outputs, -1) || !indices_good(inner, -1))
      return damage("an operator names a tensor that does not exist");
    for (uint32_t i = 0; i < inputs.size(); ++i)
      if (!is_available(inputs.scalar<int32_t>(i)))
        return damage("an operator uses a tensor before it is made");
    if (!make(outputs)) return damage("an operator writes a tensor that already has a value");
    for (uint32_t i = 0; i < outputs.size(); ++i)
      if (const auto index = outputs.scalar<int32_t>(i); index >= 0)
        tensors_[static_cast<size_t>(index)].computed = true;
    const int32_t number = codes_[code];
    out_.shapes_depend_on_data |= number == kWhere || number == kUnique;
    out_.has_state |= number == kVarHandle || number == kReadVariable || number == kAssignVariable;
    return options(op.scalar<uint8_t>(3, 0), op.table(4), graph);
  }

  Status options(uint8_t kind, const FlatTable& table, uint32_t graph) {
    switch (kind) {
      case kConcatEmbeddingsOptions:
        table.vector(1, 4);
        table.vector(2, 4);
        break;
      case kReshapeOptions:
      case kSqueezeOptions:
      case kBucketizeOptions:
        if (table.vector(0, 4).size() > kTfliteRankLimit && kind != kBucketizeOptions)
          return damage("an operator with a shape that has too many dimensions");
        break;
      case kVarHandleOptions:
        table.string(0);
        table.string(1);
        break;
      case kIfOptions:
      case kWhileOptions:
        if (!calls(graph, table.scalar<int32_t>(1, 0)))
          return damage("a call of a subgraph that does not exist");
        [[fallthrough]];
      case kCallOptions:
      case kCallOnceOptions:
        if (!calls(graph, table.scalar<int32_t>(0, 0)))
          return damage("a call of a subgraph that does not exist");
        break;
      default:
        break;
    }
    return file_.damaged() ? damage("") : ok();
  }

  Status metadata(const FlatVector& entries) {
    for (uint32_t i = 0; i < entries.size() && !file_.damaged(); ++i) {
      const FlatTable entry = entries.table(i);
      if (!entry.string(0) || entry.scalar<uint32_t>(1, 0) >= buffers_.size())
        return damage("metadata without a name or buffer");
      if (entry.string(0).text() == "TFLITE_METADATA")
        out_.metadata = buffers_[entry.scalar<uint32_t>(1, 0)].bytes();
    }
    return ok();
  }

  Status signatures(const FlatVector& signatures) {
    for (uint32_t i = 0; i < signatures.size() && !file_.damaged(); ++i) {
      const FlatTable signature = signatures.table(i);
      const auto graph = signature.scalar<uint32_t>(4, 0);
      if (!signature.string(2) || graph >= tensor_counts_.size())
        return damage("a signature without a name or subgraph");
      for (const uint32_t side : {0u, 1u})
        if (!names_tensors(signature.vector(side, 4), tensor_counts_[graph]))
          return damage("a signature that names no tensor");
    }
    return ok();
  }
  bool names_tensors(const FlatVector& list, size_t tensors) {
    for (uint32_t i = 0; i < list.size() && !file_.damaged(); ++i)
      if (!list.table(i).string(0) || list.table(i).scalar<uint32_t>(1, 0) >= tensors) return false;
    return true;
  }

  bool calls(uint32_t from, int32_t to) {
    calls_.emplace_back(from, static_cast<uint32_t>(to));
    return to >= 0 && static_cast<uint32_t>(to) < out_.subgraphs;
  }
  // Removes subgraphs without callers until none is left or the rest form cycles.
  bool calls_itself() {
    std::sort(calls_.begin(), calls_.end());
    std::vector<uint32_t> callers(out_.subgraphs);
    for (const auto& call : calls_) ++callers[call.second];
    std::vector<uint32_t> free;
    for (uint32_t i = 0; i < out_.subgraphs; ++i)
      if (callers[i] == 0) free.push_back(i);
    for (size_t done = 0; done < free.size(); ++done) {
      auto call = std::lower_bound(calls_.begin(), calls_.end(), std::pair{free[done], 0u});
      for (; call != calls_.end() && call->first == free[done]; ++call)
        if (--callers[call->second] == 0) free.push_back(call->second);
    }
    return free.size() < out_.subgraphs;
  }

  bool indices_good(const FlatVector& list, int32_t min) {
    file_.visit(list.size());
    if (file_.damaged()) return false;
    for (uint32_t i = 0; i < list.size(); ++i) {
      const auto index = list.scalar<int32_t>(i);
      if (index < min || (index >= 0 && static_cast<size_t>(index) >= tensors_.size()))
        return false;
    }
    return true;
  }
  // Call after indices_good(); -1 is an omitted input.
  bool is_available(int32_t index) const {
    return index < 0 || tensors_[static_cast<size_t>(index)].is_available();
  }
  // Call after indices_good(); false when a tensor already has a value.
  bool make(const FlatVector& list) {
    for (uint32_t i = 0; i < list.size(); ++i) {
      const auto index = list.scalar<int32_t>(i);
      if (index < 0) continue;
      auto& tensor = tensors_[static_cast<size_t>(index)];
      if (tensor.constant || tensor.made) return false;
      tensor.made = true;
    }
    return true;
  }

  FlatFile& file_;
  TfliteSummary& out_;
  std::vector<int32_t> codes_;
  std::vector<FlatVector> buffers_;
  std::vector<TfliteTensor> tensors_;  // of the current subgraph
  std::vector<uint32_t> tensor_counts_;
  std::vector<std::pair<uint32_t, uint32_t>> calls_;  // caller and callee subgraphs
};

}  // namespace

int tflite_score(std::span<const unsigned char> head) noexcept {
  return head.size() >= 8 && std::memcmp(head.data() + 4, "TFL3", 4) == 0 ? 100 : 0;
}

Status check_tflite_head(std::span<const std::byte> head) {
  if (tflite_score({reinterpret_cast<const unsigned char*>(head.data()), head.size()}) == 0)
    return tflite_damage(FlatFile({}), "no identifier TFL3 after the first 4 bytes");
  return ok();
}

Result<TfliteSummary> read_tflite(std::span<const std::byte> file) {
  if (auto status = check_tflite_head(file); !status) return status.error();
  FlatFile flat(file);
  TfliteSummary out;
  if (auto status = Walker(&flat, &out).model(); !status) return status.error();
  return out;
}

}  // namespace weir::engine
