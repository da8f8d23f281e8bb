// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/card/card.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/card/decoder_modes.hpp"
#include "core/card/fields.hpp"
#include "core/config/installed_file.hpp"
#include "core/text/json_depth.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "core/text/text_file.hpp"
#include "weir/join.hpp"

namespace weir::card {
namespace {

// A card comes with a model from anywhere. It chooses among what Weir has; only the user's command
// line can name scripts, libraries and files of other folders.

namespace fs = std::filesystem;

constexpr uint64_t kMaxCount = 65536;

// Modes that run code: a card cannot choose them, the line of a pipeline can.
constexpr std::pair<std::string_view, const char*> kCode[] = {
    {"python3", "option1=/path/to/script.py"}, {"custom-code", "option1=NAME"}};

std::string names_of_modes() {
  return join(decoder_modes(), ", ",
              [](const DecoderMode& mode) { return std::string(mode.name); });
}

// Lists the names of the properties, or the keys of `custom`.
std::string names_of_options(const DecoderMode& mode, bool are_properties) {
  std::string out;
  for (const DecoderOption& option : mode.options)
    if (!are_properties || is_decoder_property(option))
      out += (out.empty() ? "" : ", ") + std::string(option.name);
  if (are_properties && !mode.is_numbered()) out += ", custom";
  return out;
}

std::string needed_option(const DecoderMode& mode, const std::string& given, bool is_property) {
  const std::string names = names_of_options(mode, is_property);
  if (names.empty()) return "no option: mode=" + std::string(mode.name) + " has none";
  std::vector<std::string> all;
  for (const auto name : split(names, ",")) all.emplace_back(strip(name));
  const std::string close = nearest(given, all);
  return (close.empty() ? "" : "did you mean " + close + "? ") + "mode=" + std::string(mode.name) +
         " has " + names;
}

// Names what the user can do instead: set a property of an element, or an option of the command.
std::string needed_file(const DecoderOption& option) {
  const std::string elsewhere = option.name == "labels"
                                    ? "--labels FILE of weir try and weir evaluate"
                                    : "tensor_decoder in a pipeline of your own";
  return "the name of a file beside the card, without folders; for any other file, use " +
         elsewhere;
}

// Reads the value of one option. Texts of files get the folder of the card.
class DecoderOptionReader {
 public:
  DecoderOptionReader(const DecoderMode& mode, const fs::path& folder, std::string scheme)
      : mode_(mode), folder_(folder), scheme_(std::move(scheme)) {}

  // Returns nullopt, and what is needed, for a value that the option cannot have.
  std::optional<std::string> read(const DecoderOption& option, const std::string& value) {
    switch (option.value) {
      case Value::Text:
        return value;
      case Value::Fraction: {
        const auto number = parse_double(value);
        if (value.empty() || (number && *number >= 0 && *number <= 1)) return value;
        return refuse("a number from 0 to 1, as text");
      }
      case Value::Count: {
        const auto number = parse_unsigned(value);
        if (value.empty() || (number && *number <= kMaxCount)) return value;
        return refuse("a whole number from 0 to 65536, as text");
      }
      case Value::File:
        return files(option, value, "");
      case Value::Files:
        return files(option, value, ";");
      case Value::FileFirst:
        return file_first(option, value);
      case Value::Parameters:
        return starts_with_file() ? file_first(option, value) : value;
    }
    return std::nullopt;
  }

  // Reads the value of the property custom: key:value,key:value.
  std::optional<std::string> read_custom(const std::string& text) {
    std::string out;
    for (const auto part : split(text, ",")) {
      const auto item = strip(part);
      if (item.empty()) continue;
      const size_t colon = item.find(':');
      const std::string key(strip(item.substr(0, colon)));
      if (colon == std::string_view::npos) return refuse("key:value for each option, with commas");
      const DecoderOption* option = mode_.option(key);
      if (!option) return refuse(needed_option(mode_, key, false));
      const auto value = read(*option, std::string(strip(item.substr(colon + 1))));
      if (!value) return std::nullopt;
      // A comma of the folder would begin another option.
      if (value->find(',') != std::string::npos) return refuse_folder(",");
      out += (out.empty() ? "" : ",") + key + ":" + *value;
    }
    return out;
  }

  const std::string& needed() const noexcept { return needed_; }

 private:
  std::optional<std::string> refuse(std::string needed) {
    needed_ = std::move(needed);
    return std::nullopt;
  }
  std::optional<std::string> refuse_folder(const std::string& separator) {
    return refuse("a card in a folder whose path has no \"" + separator +
                  "\", which separates the parts of this value");
  }
  // Returns whether the scheme of bounding_boxes is the one that reads prior boxes from a file.
  bool starts_with_file() const {
    return equal_ignoring_case(scheme_, "mobilenet-ssd") ||
           equal_ignoring_case(scheme_, "tflite-ssd");
  }

  std::optional<std::string> files(const DecoderOption& option, const std::string& value,
                                   std::string_view separator) {
    if (value.empty()) return value;
    std::string out;
    for (const auto name : split(value, separator)) {
      if (!is_name_of_a_file(name)) return refuse(needed_file(option));
      out += (out.empty() ? "" : std::string(separator)) + (folder_ / name).string();
    }
    if (!separator.empty() && folder_.string().find(separator) != std::string::npos)
      return refuse_folder(std::string(separator));
    return out;
  }

  std::optional<std::string> file_first(const DecoderOption& option, const std::string& value) {
    const size_t colon = std::min(value.find(':'), value.size());
    const auto file = files(option, value.substr(0, colon), "");
    if (!file) return std::nullopt;
    if (file->find(':') != std::string::npos) return refuse_folder(":");
    return *file + value.substr(colon);
  }

  const DecoderMode& mode_;
  const fs::path& folder_;
  const std::string scheme_;
  std::string needed_;
};

std::string get_text(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}

// Reads the field `decoder`: the name of one of decoder_modes(), "" for none or a faulty one.
std::string decoder_from(Fields* fields) {
  std::string mode = fields->text("decoder", false);
  if (mode.empty() || find_decoder_mode(mode)) return mode;
  for (const auto& [name, options] : kCode)
    if (equal_ignoring_case(mode, name)) {
      fields->fail("decoder", "a mode that runs no code: " + names_of_modes() +
                                  "; to run your own, write tensor_decoder mode=" +
                                  std::string(name) + " " + options + " into a pipeline");
      return "";
    }
  std::vector<std::string> names;
  for (const DecoderMode& known : decoder_modes()) names.emplace_back(known.name);
  const std::string close = nearest(mode, names);
  fields->fail("decoder", close.empty()
                              ? "null, or a mode that comes with Weir: " + names_of_modes()
                              : "did you mean " + close + "?");
  return "";
}

// Reads the field `decoder_options`: properties of tensor_decoder with this mode. Names of files
// get `folder`.
std::vector<std::pair<std::string, std::string>> decoder_options_from(Fields* fields,
                                                                      const std::string& mode_name,
                                                                      const fs::path& folder,
                                                                      Faults* faults) {
  std::vector<std::pair<std::string, std::string>> out;
  const Json* given = fields->find("decoder_options", false);
  if (!given) return out;
  Fields options(*given, fields->where("decoder_options"), faults);
  if (!given->is_object() || fields->has_fault("decoder")) return out;
  const DecoderMode* mode = find_decoder_mode(mode_name);
  if (!mode && !given->empty()) fields->fail("decoder_options", "a decoder that has these options");
  if (!mode) return out;
  DecoderOptionReader reader(*mode, folder, get_text(*given, "option1"));
  for (const auto& [name, json] : given->items()) {
    const bool is_custom = name == "custom" && !mode->is_numbered();
    const DecoderOption* option = mode->option(name);
    if (!is_custom && !(option && is_decoder_property(*option))) {
      options.fail(name, needed_option(*mode, name, true));
    } else if (!json.is_string()) {
      options.fail(name, "a string: the value of this property of tensor_decoder");
    } else if (const auto text = json.get<std::string>(); !is_plain_text(text)) {
      options.fail(name, kPlainText);
    } else if (auto value = is_custom ? reader.read_custom(text) : reader.read(*option, text)) {
      out.emplace_back(name, *std::move(value));
    } else {
      options.fail(name, reader.needed());
    }
  }
  return out;
}

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
  if (input->resize != Fit::Letterbox) fields->fail("padding", "\"resize\": \"letterbox\"");
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
  input.resize = fields.one_of<Fit>(
      "resize", {{"stretch", Fit::Stretch}, {"crop", Fit::Crop}, {"letterbox", Fit::Letterbox}},
      Fit::Stretch, false);
  read_padding(&fields, &input);
  input.mean = floats_from(&fields, "mean");
  input.scale = floats_from(&fields, "scale");
  check_input(input, &fields);
  return input;
}

Labels label_file_from(Fields* file) {
  Labels out;
  file->only({"file", "skip"});
  out.file = file->text("file", true);
  if (!out.file.empty() && !is_name_of_a_file(out.file))
    file->fail("file", "a file name without folders");
  if (const Json* skip = file->find("skip", false)) {
    if (skip->is_number_unsigned()) out.skip = skip->get<size_t>();
    if (!skip->is_number_unsigned()) file->fail("skip", "a number of lines");
  }
  return out;
}

Labels labels_from(Fields* fields, Faults* faults) {
  Labels out;
  const Json* value = fields->find("labels", false);
  if (!value) return out;
  if (value->is_object()) {
    Fields file(*value, fields->where("labels"), faults);
    return label_file_from(&file);
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
  if (json_depth(text) > kDepthLimit)
    return invalid(place + ": objects that are nested too deeply", "a card");
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    return invalid(place + ": not JSON at byte " + std::to_string(error.byte), "JSON");
  } catch (const Json::exception&) {  // a number out of range
    return invalid(place + ": a number that is too large",
                   "JSON with numbers that fit into 64 bits");
  }
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
