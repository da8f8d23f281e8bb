// Reads frames of results and passes them to the writer of a text format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <charconv>
#include <cstring>
#include <limits>

#include "core/decoders/stream_model.hpp"
#include "core/heads/readings.hpp"
#include "core/records/record_writer.hpp"
#include "weir/decoder.hpp"

namespace weir::decoders {
namespace {

using records::FrameFacts;
using records::ResultTensor;
using records::WriterSettings;

struct Mode {
  const char* name;
  const char* caps;
  const char* options_json;
  std::unique_ptr<records::RecordWriter> (*writer)(WriterSettings settings);
};

#define WEIR_RECORD_OPTIONS                                                                    \
  R"([{"name":"labels","type":"text","default":"","help":"Label file; several, separated by )" \
  R"(semicolons, for the sources of the results in their order"},)"                            \
  R"({"name":"threshold","type":"number","default":"0","help":"Minimum score that is written"})"

constexpr Mode kModes[] = {
    {"json", "application/x-json",
     WEIR_RECORD_OPTIONS R"(,{"name":"masks","type":"values: none|rle","default":"none","help":)"
                         R"("rle: write masks and class maps, run-length coded"}])",
     records::json_writer},
    {"webvtt", "application/x-subtitle-vtt", WEIR_RECORD_OPTIONS "]", records::webvtt_writer},
    {"coco", "application/x-json",
     WEIR_RECORD_OPTIONS R"(,{"name":"categories","type":"values: index|coco","default":"index",)"
                         R"("help":"coco: ids 1 to 90 of COCO for the class indices 0 to 79"}])",
     records::coco_writer},
    {"mot", "text/csv", WEIR_RECORD_OPTIONS "]", records::mot_writer}};

float read_threshold(const Options& options) {
  const auto text = options.get("threshold");
  if (!text || text->empty()) return 0;
  float value = 0;
  const char* last = text->data() + text->size();
  const auto [end, error] = std::from_chars(text->data(), last, value);
  if (error != std::errc() || end != last || !(value >= 0 && value <= 1))
    throw Failure({.code = Code::OPTION_VALUE,
                   .what = "the value of threshold cannot be used",
                   .offered = "threshold=" + std::string(*text),
                   .needed = "a number from 0 to 1",
                   .fix = "threshold=0.5"});
  return value;
}

// True for `yes`, false for `no` or no value.
bool read_choice(const Options& options, const char* option, const char* no, const char* yes) {
  const auto text = options.get(option);
  if (!text || text->empty() || *text == no) return false;
  if (*text == yes) return true;
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = std::string("the value of ") + option + " cannot be used",
                 .offered = option + ("=" + std::string(*text)),
                 .needed = std::string(no) + " or " + yes,
                 .fix = std::string("custom=") + option + ":" + yes});
}

TensorSpec to_spec(const weir_tensor_info& info) {
  TensorSpec out;
  if (info.type < WEIR_TYPE_END) out.type = static_cast<ElementType>(info.type);
  const uint32_t rank = std::min<uint32_t>(info.rank, WEIR_RANK_LIMIT);
  for (uint32_t i = 0; i < rank; ++i) {
    const int64_t extent = info.shape[rank - 1 - i];
    out.shape[i] = extent > 0 && extent <= UINT32_MAX ? static_cast<uint32_t>(extent) : 0;
  }
  const bool is_open = std::any_of(info.shape, info.shape + rank, [](int64_t n) { return n < 0; });
  if (rank == info.rank && rank > 0 && !is_open) out.shape.set_rank(rank);
  return out;
}

class RecordDecoder {
 public:
  RecordDecoder(const Options& options, const Mode& mode) : mode_(mode) {
    settings_.labels =
        records::read_labels("labels", std::string(options.get("labels").value_or("")));
    settings_.threshold = read_threshold(options);
    settings_.has_masks = read_choice(options, "masks", "none", "rle");
    settings_.has_coco_ids = read_choice(options, "categories", "index", "coco");
  }

  void set_caps(const Options& fields) noexcept {
    columns_ = fields.get(WEIR_RESULTS_COLUMNS).value_or("");
    sources_ = fields.get(WEIR_RESULTS_SOURCE).value_or("");
  }
  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }
  void set_labels(const char* source, std::span<const char* const> names) noexcept try {
    labels_[source] = std::vector<std::string>(names.begin(), names.end());
    if (!writer_) return;
    writer_->set_labels(labels());
    writer_->set_zone_names(zone_names());
  } catch (const std::exception&) {
    labels_.clear();  // out of memory: as if the stream had none
  }
  void set_stream(const DecoderStream& stream) noexcept {
    // A frame's duration where it has none itself.
    duration_ = stream.rate_n > 0 ? int64_t{1000000000} * stream.rate_d / stream.rate_n : -1;
  }
  void set_times(const DecoderTimes& times) noexcept { times_ = times; }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    reader_ = value_or_throw(records::ResultReader::make(columns_, sources_));
    std::vector<TensorSpec> specs;
    for (const auto& info : inputs) specs.push_back(to_spec(info));
    if (const Status status = specs.empty() ? ok() : reader_.check(specs); !status)
      throw Failure(with_reading(status.error(), inputs));
    WriterSettings settings = settings_;
    settings.labels = labels();
    settings.zones = zone_names();
    writer_ = mode_.writer(std::move(settings));
    output.set_caps(mode_.caps);
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    tensors_.clear();
    for (uint32_t i = 0; i < frame.n_tensors; ++i) {
      const weir_tensor& tensor = frame.tensors[i];
      tensors_.push_back(
          {to_spec(tensor.info), {static_cast<const std::byte*>(tensor.data), tensor.bytes}});
    }
    // A frame without tensors has no results.
    frame_.clear();
    if (!tensors_.empty()) value_or_throw(reader_.read(tensors_, &frame_));
    text_.clear();
    const bool is_written = writer_->write(reader_, frame_, make_facts(frame), &text_);
    times_ = {};
    if (!is_written) return false;
    std::memcpy(output.reserve(text_.size()).data(), text_.data(), text_.size());
    return true;
  }
  void reset() noexcept {
    if (writer_) writer_->restart();
  }

 private:
  // Those of the user, else of the stream, else of the model whose outputs are read as rows.
  records::Labels labels() const {
    if (!settings_.labels.empty()) return settings_.labels;
    auto of_stream = records::labels_of_sources(labels_, reader_.sources());
    if (of_stream.empty() && !model_.labels().empty()) of_stream.push_back(model_.labels());
    return records::Labels(std::move(of_stream));
  }
  // The outputs of a model are read as results first, in the mode that suits them.
  Error with_reading(Error error, std::span<const weir_tensor_info> inputs) const {
    if (model_.name().empty()) return error;
    if (const auto reading = heads::only_reading(model_.facts(inputs, {}, 0)))
      error.fix = "tensor_decoder mode=" + reading->mode + " ! tensor_decoder";
    return error;
  }
  std::vector<std::string> zone_names() const {
    const auto known = labels_.find(reader_.zone_source());
    return reader_.has_zones() && known != labels_.end() ? known->second
                                                         : std::vector<std::string>();
  }
  FrameFacts make_facts(const weir_frame& frame) const {
    FrameFacts out{.running_time = times_.running_time,
                   .duration = frame.duration >= 0 ? frame.duration : duration_,
                   .unix_time = times_.unix_time};
    if (!has_map_fields(frame) || !frame.maps) return out;
    for (uint32_t i = 0; i < frame.n_maps; ++i) out.maps.push_back(source_map(frame.maps[i]));
    if (out.maps.empty()) return out;
    out.width = out.maps[0].source_width;
    out.height = out.maps[0].source_height;
    if (frame.maps_of == WEIR_MAPS_OF_REGIONS) out.maps.clear();
    return out;
  }

  const Mode& mode_;
  WriterSettings settings_;  // with the user's labels
  std::string columns_, sources_;
  StreamModel model_;
  records::LabelsBySource labels_;  // of the stream
  int64_t duration_ = -1;
  DecoderTimes times_;
  records::ResultReader reader_;
  std::unique_ptr<records::RecordWriter> writer_;
  // Kept for their memory.
  std::vector<ResultTensor> tensors_;
  records::ResultFrame frame_;
  std::string text_;
};

template <size_t kMode>
class ModeDecoder final : public RecordDecoder {
 public:
  explicit ModeDecoder(const Options& options) : RecordDecoder(options, kModes[kMode]) {}
};

template <size_t kMode>
const weir_decoder_type* get_table() {
  static const weir_decoder_type table =
      decoder_table<ModeDecoder<kMode>>(kModes[kMode].name, "", kModes[kMode].options_json);
  return &table;
}

}  // namespace

std::span<const weir_decoder_type* const> record_decoders() {
  static const weir_decoder_type* const tables[] = {get_table<0>(), get_table<1>(), get_table<2>(),
                                                    get_table<3>()};
  return tables;
}

}  // namespace weir::decoders
