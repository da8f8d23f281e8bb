// Parses model cards from JSON and checks each field by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/card.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/card/card_decoder.hpp"
#include "core/card/fields.hpp"
#include "core/config/installed_file.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "core/text/text_file.hpp"
#include "weir/join.hpp"

namespace weir::card {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBytesLimit = size_t{1} << 20;
constexpr int kDepthLimit = 16;
constexpr int64_t kSideLimit = 1 << 15;

void read_padding(Fields* fields, ImageInput* input) {
  const Json* padding = fields->find("padding", false);
  if (!padding) return;
  if (padding->is_number_unsigned() && *padding <= 255)
    input->padding = padding->get<uint8_t>();
  else
    fields->fail("padding", "a pixel value from 0 to 255");
  if (input->resize != Resize::Letterbox) fields->fail("padding", "\"resize\": \"letterbox\"");
}

// Returns extents of 0 if one of them is faulty.
std::vector<int64_t> shape_from(Fields* fields) {
  const auto given = fields->numbers("shape");
  const bool whole = std::all_of(given.begin(), given.end(), [](double extent) {
    return extent >= 1 && extent <= kSideLimit && std::trunc(extent) == extent;
  });
  if (whole) return {given.begin(), given.end()};
  fields->fail("shape", "whole numbers from 1 to " + std::to_string(kSideLimit));
  return std::vector<int64_t>(given.size(), 0);
}

// Reads numbers that fit into 32 bits, with which pixels are prepared.
std::vector<double> floats_from(Fields* fields, const char* key) {
  auto out = fields->numbers(key);
  const bool fit = std::all_of(out.begin(), out.end(), [](double number) {
    return std::abs(number) <= double{std::numeric_limits<float>::max()};
  });
  if (!fit) fields->fail(key, "numbers that fit into 32 bits, up to 3.4e38");
  return out;
}

void check_input(const ImageInput& input, Fields* fields) {
  const bool picture =
      (input.shape.size() == 3 || (input.shape.size() == 4 && input.shape[0] == 1)) &&
      !std::count(input.shape.begin(), input.shape.end(), 0);
  if (!picture)
    return fields->fail(
        "shape", "the extents of one picture in the order of `layout`, such as [1, 224, 224, 3]");
  if (fields->has_fault("color") || fields->has_fault("layout")) return;
  const int64_t channels = input.color == Color::Gray ? 1 : 3;
  if (input.channels() != channels)
    fields->fail("shape", std::to_string(channels) + " channels at the position given by `layout`");
  for (const char* key : {"mean", "scale"}) {
    const auto count = static_cast<int64_t>((*key == 'm' ? input.mean : input.scale).size());
    if (count > 1 && count != channels) fields->fail(key, "one number, or one for each channel");
  }
}

ImageInput input_from(const Json& json, const std::string& where, Faults* faults) {
  Fields fields(json, where, faults);
  fields.only({"name", "type", "shape", "layout", "color", "mean", "scale", "resize", "padding"});
  ImageInput input;
  input.name = fields.text("name", false);
  input.type = parse_element_type(fields.text("type", true));
  if (input.type == ElementType::End) fields.fail("type", "an element type, such as float32");
  input.shape = shape_from(&fields);
  input.layout = fields.one_of<Layout>("layout", {{"NHWC", Layout::Nhwc}, {"NCHW", Layout::Nchw}},
                                       Layout::Nhwc, true);
  input.color = fields.one_of<Color>(
      "color", {{"RGB", Color::Rgb}, {"BGR", Color::Bgr}, {"GRAY8", Color::Gray}}, Color::Rgb,
      true);
  input.resize = fields.one_of<Resize>(
      "resize",
      {{"stretch", Resize::Stretch}, {"crop", Resize::Crop}, {"letterbox", Resize::Letterbox}},
      Resize::Stretch, false);
  read_padding(&fields, &input);
  input.mean = floats_from(&fields, "mean");
  input.scale = floats_from(&fields, "scale");
  check_input(input, &fields);
  return input;
}

Labels labels_from(Fields* fields, Faults* faults) {
  Labels out;
  const Json* value = fields->find("labels", false);
  if (!value) return out;
  if (value->is_object()) {
    Fields file(*value, fields->where("labels"), faults);
    file.only({"file", "skip"});
    out.file = file.text("file", true);
    if (!out.file.empty() && !is_name_of_a_file(out.file))
      file.fail("file", "a file name without folders");
    if (const Json* skip = file.find("skip", false)) {
      if (skip->is_number_unsigned()) out.skip = skip->get<size_t>();
      if (!skip->is_number_unsigned()) file.fail("skip", "a number of lines");
    }
    return out;
  }
  const bool texts =
      value->is_array() &&
      std::all_of(value->begin(), value->end(), [](auto& label) { return label.is_string(); });
  if (!texts) {
    fields->fail("labels", "a list of strings, or {\"file\": ..., \"skip\": ...}");
    return out;
  }
  for (size_t i = 0; i < value->size(); ++i) {
    const auto& label = (*value)[i].get_ref<const std::string&>();
    if (!is_plain_text(label))
      fields->fail_at("labels/" + std::to_string(i), (*value)[i], kPlainText);
  }
  out.names = value->get<std::vector<std::string>>();
  return out;
}

Card card_from(const Json& json, const std::string& place, const fs::path& folder, Faults* faults) {
  Fields fields(json, place, faults);
  fields.only({"name", "model", "sha256", "task", "inputs", "outputs", "labels", "decoder",
               "decoder_options", "provenance"});
  Card card;
  card.name = fields.text("name", true);
  card.model = fields.text("model", true);
  card.task = fields.text("task", false);
  card.sha256 = lower(fields.text("sha256", true));
  if (card.sha256.size() != 64 ||
      card.sha256.find_first_not_of("0123456789abcdef") != std::string::npos)
    fields.fail("sha256", "64 hexadecimal digits: sha256sum MODEL");
  card.decoder = decoder_from(&fields);
  card.decoder_options = decoder_options_from(&fields, card.decoder, folder, faults);
  card.labels = labels_from(&fields, faults);
  const Json* provenance = fields.find("provenance", true);
  if (provenance && !provenance->is_object())
    fields.fail("provenance", "an object: source, licence");
  const Json* inputs = fields.find("inputs", true);
  if (inputs && (!inputs->is_array() || inputs->empty()))
    fields.fail("inputs", "a list of at least one input");
  if (inputs && inputs->is_array())
    for (size_t i = 0; i < inputs->size(); ++i)
      card.inputs.push_back(
          input_from((*inputs)[i], fields.where("inputs") + "/" + std::to_string(i), faults));
  return card;
}

Error invalid(const std::string& offered, const std::string& needed) {
  return Error{.code = Code::CARD_INVALID,
               .what = "the model card cannot be used",
               .offered = offered,
               .needed = needed,
               .fix = "docs/cards.md lists the fields of a card"};
}

// The first fault, and the others below it.
Error invalid(const Faults& faults) {
  Error out = invalid(faults[0].place + ": " + faults[0].value, faults[0].needed);
  const size_t others = faults.size() - 1;
  if (others == 0) return out;
  out.difference = std::to_string(others) + (others == 1 ? " more error:" : " more errors:");
  for (size_t i = 1; i < faults.size(); ++i)
    out.difference +=
        "\n    " + faults[i].place + ": " + faults[i].value + ", needed: " + faults[i].needed;
  return out;
}

Error not_read(const std::string& path) {
  Error out{.code = Code::FILE_NOT_FOUND,
            .what = "the model card cannot be read",
            .offered = path,
            .needed = "a file that can be read",
            .difference = why_unreadable(path),
            .fix = "the path of a card; docs/cards.md describes its fields"};
  if (const auto installed = config::installed_file(path); !installed.empty()) {
    out.difference = "Weir is installed below another prefix";
    out.fix = "card=" + launch_value(installed);
  }
  return out;
}

}  // namespace

int64_t ImageInput::width() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 2 : 1)];
}
int64_t ImageInput::height() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 3 : 2)];
}
int64_t ImageInput::channels() const noexcept {
  return shape[shape.size() - (layout == Layout::Nhwc ? 1 : 3)];
}

Result<Card> parse(std::string_view text, const std::string& place, const fs::path& folder) {
  if (text.size() > kBytesLimit)
    return invalid(place + ": " + std::to_string(text.size()) + " bytes",
                   "a card of at most 1 MiB");
  // Deeper than any card: rejected while parsing, so that nesting costs no memory.
  bool too_deep = false;
  const auto bounded = [&too_deep](int depth, Json::parse_event_t, Json&) {
    too_deep |= depth > kDepthLimit;
    return !too_deep;
  };
  Json json;
  try {
    json = Json::parse(text, bounded);
  } catch (const Json::parse_error& error) {
    return invalid(place + ": not JSON at byte " + std::to_string(error.byte), "JSON");
  } catch (const Json::exception&) {  // a number out of range
    return invalid(place + ": a number that is too large",
                   "JSON with numbers that fit into 64 bits");
  }
  if (too_deep) return invalid(place + ": objects that are nested too deeply", "a card");
  Faults faults;
  Card card = card_from(json, place, folder, &faults);
  if (!faults.empty()) return invalid(faults);
  return card;
}

Result<Card> read(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return not_read(path);  // opening a FIFO would wait
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open()) return not_read(path);
  std::string text(kBytesLimit + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  auto card = parse(text, path, fs::path(path).parent_path());
  if (card) card->path = path;
  return card;
}

}  // namespace weir::card
