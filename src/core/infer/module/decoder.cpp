// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/decoder.hpp"

#include <cstddef>
#include <nlohmann/json.hpp>

namespace weir::infer {
namespace {

// Modules may have been built before a table got its last members.
constexpr size_t kLabelsBeforeClasses = offsetof(weir_decoder_labels, classes);

// The decoder's table of the extension `id`, of at least `kMin` bytes; null if it does not have
// it.
template <class Table, size_t kMin = sizeof(Table)>
const Table* find_extension(const weir_decoder_type& type, const char* id) {
  const bool extensible =
      type.struct_size >= offsetof(weir_decoder_type, extension) + sizeof type.extension;
  if (!extensible || !type.extension) return nullptr;
  const auto* table = static_cast<const Table*>(type.extension(id));
  return table && table->struct_size >= kMin ? table : nullptr;
}

}  // namespace

std::vector<std::string> option_names(const weir_decoder_type& type) {
  std::vector<std::string> out;
  const auto list =
      nlohmann::json::parse(type.options_json ? type.options_json : "", nullptr, false);
  if (!list.is_array()) return out;
  for (const auto& option : list)
    if (option.is_object() && option.contains("name") && option["name"].is_string())
      out.push_back(option["name"].get<std::string>());
  return out;
}

Decoder::Decoder(const weir_decoder_type& type, weir_decoder* handle)
    : type_(type),
      handle_(handle),
      stream_(find_extension<weir_decoder_stream>(type, WEIR_DECODER_STREAM)),
      model_(find_extension<weir_decoder_model>(type, WEIR_DECODER_MODEL)),
      caps_(find_extension<weir_decoder_caps>(type, WEIR_DECODER_CAPS)),
      times_(find_extension<weir_decoder_times>(type, WEIR_DECODER_TIMES)),
      labels_(
          find_extension<weir_decoder_labels, kLabelsBeforeClasses>(type, WEIR_DECODER_LABELS)) {}

void Decoder::set_model(const weir_stream_model* model) noexcept {
  if (uses_model()) model_->set_model(handle_, model);
}

void Decoder::set_stream(const Fraction& rate, Format format) noexcept {
  const Fraction given = rate.valid() ? rate : Fraction{0, 1};
  if (stream_ && stream_->set_stream)
    stream_->set_stream(handle_, given.numerator, given.denominator, format == Format::Flexible);
}

void Decoder::set_caps(const Options& fields) {
  if (!caps_ || !caps_->set_caps) return;
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : fields) pairs.push_back({key.c_str(), value.c_str()});
  caps_->set_caps(handle_, pairs.data(), static_cast<uint32_t>(pairs.size()));
}

void Decoder::set_times(int64_t running_time, int64_t unix_time) noexcept {
  if (times_ && times_->set_times) times_->set_times(handle_, running_time, unix_time);
}

std::vector<std::string> Decoder::labels() const {
  const char* const* names = nullptr;
  const uint32_t count = labels_ && labels_->labels ? labels_->labels(handle_, &names) : 0;
  return {names, names + count};
}

size_t Decoder::classes() const noexcept {
  const bool has_count = labels_ && labels_->struct_size > kLabelsBeforeClasses && labels_->classes;
  return has_count ? labels_->classes(handle_) : 0;
}

void Decoder::set_labels(const std::string& source, const std::vector<std::string>& names) {
  if (!reads_results()) return;
  std::vector<const char*> texts;
  texts.reserve(names.size());
  for (const auto& name : names) texts.push_back(name.c_str());
  labels_->set_labels(handle_, source.c_str(), texts.data(), static_cast<uint32_t>(texts.size()));
}

bool Decoder::needs_headers() const noexcept {
  return stream_ && stream_->set_stream && (stream_->flags & WEIR_DECODER_WITH_HEADERS) != 0;
}

Result<std::unique_ptr<Decoder>> Decoder::open(const weir_decoder_type& type,
                                               const Options& options) {
  std::vector<weir_option> pairs;
  for (const auto& [key, value] : options) pairs.push_back({key.c_str(), value.c_str()});
  weir_error error;
  weir_decoder* handle = nullptr;
  const int result =
      type.open(pairs.data(), static_cast<uint32_t>(pairs.size()), nullptr, &handle, &error);
  if (result < 0 || !handle)
    return take_error(&error, result < 0 ? result : -WEIR_INTERNAL, "the decoder cannot be opened");
  return std::unique_ptr<Decoder>(new Decoder(type, handle));
}

Decoder::~Decoder() {
  type_.close(handle_);
}

Status Decoder::configure(const std::vector<weir_tensor_info>& inputs, weir_sink* sink) {
  weir_error error;
  const int result = type_.configure(handle_, inputs.data(), static_cast<uint32_t>(inputs.size()),
                                     "", sink, &error);
  if (result < 0) return take_error(&error, result, "the decoder rejects these tensors");
  return ok();
}

Result<bool> Decoder::decode(const weir_frame& frame, weir_sink* sink) {
  weir_error error;
  const int result = type_.decode(handle_, &frame, sink, &error);
  warning_.reset();
  if (result < 0) return take_error(&error, result, "the decoder failed on a frame");
  if (error.set) warning_ = std::move(error.error);
  return result == 0;
}

void Decoder::reset() noexcept {
  if (type_.reset) type_.reset(handle_);
}

}  // namespace weir::infer
