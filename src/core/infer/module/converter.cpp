// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/converter.hpp"

#include <algorithm>
#include <cstddef>

#include "weir/abi.h"

namespace weir::infer {
namespace {

std::string get_name(const weir_converter_type& type) {
  return "the converter " + std::string(type.name);
}

class ModuleConverter final : public Converter {
 public:
  ModuleConverter(const weir_converter_type& type, weir_converter* handle)
      : who_(get_name(type)),
        type_(type),
        handle_(handle),
        rate_(extension<weir_converter_rate>(type, WEIR_CONVERTER_RATE)),
        stream_(extension<weir_converter_stream>(type, WEIR_CONVERTER_STREAM)) {}
  ~ModuleConverter() override { type_.close(handle_); }
  ModuleConverter(const ModuleConverter&) = delete;
  ModuleConverter& operator=(const ModuleConverter&) = delete;

  Result<std::vector<TensorSpec>> configure(const std::string& caps) override {
    weir_error error;
    std::vector<weir_tensor_info> infos(WEIR_TENSOR_LIMIT);
    uint32_t count = WEIR_TENSOR_LIMIT;
    const int result = type_.configure(handle_, caps.c_str(), infos.data(), &count, &error);
    if (result < 0) return take_error(&error, result, who_ + " rejects these caps");
    if (count > WEIR_TENSOR_LIMIT)
      return Error{.code = Code::CALLBACK_FAILED,
                   .what = who_ + " declares more tensors than there is room for",
                   .offered = std::to_string(count),
                   .needed = "at most 256",
                   .fix = "correct " + who_};
    std::vector<TensorSpec> specs;
    for (uint32_t i = 0; i < count; ++i) {
      if (open_parts(infos[i])) return std::vector<TensorSpec>{};
      const auto spec = to_spec(who_, infos[i]);
      if (!spec) return spec.error();
      if (spec->shape.is_empty()) return std::vector<TensorSpec>{};  // the first frame decides
      specs.push_back(*spec);
    }
    return specs;
  }

  Result<ConvertedFrame> convert(const weir_frame& in) override {
    weir_error error;
    const int result = type_.convert(handle_, &in, room_.prepare(in), &error);
    const bool flexible =
        result == 0 && stream_ && stream_->is_flexible && stream_->is_flexible(handle_) != 0;
    auto out = room_.take(result, &error, flexible);
    Fraction rate;
    if (out && !out->tensors.empty() && rate_ && rate_->rate &&
        rate_->rate(handle_, &rate.numerator, &rate.denominator) == 1) {
      if (!rate.valid())
        return Error{
            .code = Code::CALLBACK_FAILED,
            .what = who_ + " declares an invalid frame rate",
            .offered = std::to_string(rate.numerator) + "/" + std::to_string(rate.denominator),
            .needed = "0/1 or more",
            .fix = "correct " + who_};
      out->rate = rate;
    }
    return out;
  }

  void reset() noexcept override {
    if (type_.reset) type_.reset(handle_);
  }

 private:
  // Null if the converter does not have the extension.
  template <class Table>
  static const Table* extension(const weir_converter_type& type, const char* id) {
    const bool extensible =
        type.struct_size >= offsetof(weir_converter_type, extension) + sizeof type.extension;
    if (!extensible || !type.extension) return nullptr;
    const auto* table = static_cast<const Table*>(type.extension(id));
    return table && table->struct_size >= sizeof *table ? table : nullptr;
  }

  // Rule C of abi.h: -1 and WEIR_RANK_UNKNOWN are unknown.
  static bool open_parts(const weir_tensor_info& info) {
    if (info.rank == WEIR_RANK_UNKNOWN) return true;
    const uint32_t rank = std::min<uint32_t>(info.rank, WEIR_RANK_LIMIT);
    return std::any_of(info.shape, info.shape + rank, [](int64_t extent) { return extent == -1; });
  }

  const std::string who_;
  const weir_converter_type& type_;
  weir_converter* handle_;
  const weir_converter_rate* rate_;      // null: frames have the rate of the stream
  const weir_converter_stream* stream_;  // null: frames are static
  ConverterRoom room_{who_};
};

}  // namespace

Result<std::unique_ptr<Converter>> Converter::open(const weir_converter_type& type,
                                                   const Options& options) {
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : options) pairs.push_back({key.c_str(), value.c_str()});
  weir_error error;
  weir_converter* handle = nullptr;
  const int result =
      type.open(pairs.data(), static_cast<uint32_t>(pairs.size()), nullptr, &handle, &error);
  if (result < 0) return take_error(&error, result, get_name(type) + " cannot be opened");
  if (!handle)
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = get_name(type) + " cannot be opened",
                 .offered = "0 and no handle from its open",
                 .needed = "a handle, or a negative number",
                 .fix = "correct " + get_name(type)};
  return std::unique_ptr<Converter>(std::make_unique<ModuleConverter>(type, handle));
}

}  // namespace weir::infer
