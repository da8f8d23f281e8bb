// Opens the model and writes the template of core/card/find_card.hpp.
// SPDX-License-Identifier: LGPL-2.1-or-later

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "commands.hpp"
#include "core/card/find_card.hpp"
#include "core/infer/model/model.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/shell_quote.hpp"
#include "inspect/command_error.hpp"
#include "inspect/model_card.hpp"
#include "models/catalogue.hpp"
#include "report.hpp"
#include "try/try_model.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

Error no_picture(const CardOptions& options, const infer::Model& model) {
  const auto& inputs = model.inputs();
  const bool is_open = std::any_of(inputs.begin(), inputs.end(), [](const weir_tensor_info& info) {
    return info.rank == WEIR_RANK_UNKNOWN;
  });
  const std::string file = shell_word(options.model);
  if (is_open)
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the file does not have the dimensions of its inputs, which a card needs",
                 .offered = options.model,
                 .needed = "the same model in a format that has them, such as .onnx or .tflite",
                 .fix = "weir inspect " + file};
  return Error{
      .code = Code::MODEL_UNSUPPORTED,
      .what = "the model has no input for pictures, and a card describes only these",
      .offered = options.model,
      .needed = "an input with 3 or 4 dimensions, one of them 1 or 3 (the colour channels)",
      .fix = "weir inspect " + file};
}

Result<std::string> card_text(const CardOptions& options) {
  infer::OpenOptions request;
  request.paths = {options.model};
  auto& library = infer::ModuleLibrary::instance();
  const auto engine = options.engine.empty() ? library.engine_for_model(request.paths)
                                             : library.engine(options.engine);
  if (!engine) return command_error(engine.error());
  const auto model = infer::Model::open(**engine, request);
  if (!model) return command_error(model.error());
  auto search = card_search(options.model, **model);
  if (search.inputs.empty()) return no_picture(options, **model);
  TryOptions tried;
  tried.model = options.model;
  tried.engine = options.engine;
  const auto read = try_model(tried, **model);
  if (!read)
    std::fprintf(stderr, "weir try cannot fill in the pixels and the mode:\n%s\n\n",
                 read.error().message().c_str());
  if (read && read->input) {
    search.from_model = {*read->input};
    search.decoder = read->mode;
    if (!read->notes.empty())
      std::fputs("The pixels and the mode are what weir try assumes: correct what is wrong.\n",
                 stderr);
  }
  return card::card_to_fill_in(search) + "\n";
}

Error not_written(const CardOptions& options, const std::string& path, int reason) {
  Error out{.code = Code::FILE_NOT_WRITTEN,
            .what = "the card cannot be written",
            .offered = path,
            .needed = "a writable folder",
            .difference = std::strerror(reason)};
  if (reason != EEXIST) return out;
  out.what = "a file with this name already exists";
  out.needed = "an unused name";
  out.difference = "";
  out.fix = "weir card " + shell_word(options.model) + " --output new.card.json";
  return out;
}

// A card that is there already is not replaced.
void print_place(const CardOptions& options) {
  const auto card = fs::path(options.model).replace_extension(".card.json");
  std::error_code ignored;
  if (fs::exists(card, ignored)) return;
  const std::string engine =
      options.engine.empty() ? "" : " --engine " + shell_word(options.engine);
  std::fprintf(stderr, "\nTo write it where Weir finds it: weir card %s%s --output %s\n",
               shell_word(options.model).c_str(), engine.c_str(),
               shell_word(card.string()).c_str());
}

}  // namespace

int write_card(const CardOptions& given) {
  CardOptions options = given;
  const auto model_file = file_of_model(given.model);
  if (!model_file) return report(model_file.error(), false);
  options.model = *model_file;
  const auto text = card_text(options);
  if (!text) return report(text.error(), false);
  if (options.output.empty() || options.output == "-") {
    std::fputs(text->c_str(), stdout);
    if (options.output.empty()) print_place(options);
    return kExitGood;
  }
  const std::string& path = options.output;
  std::FILE* const file = std::fopen(path.c_str(), "wx");  // x: fails if it exists
  if (!file) return report(not_written(options, path, errno), false);
  const bool is_written = std::fputs(text->c_str(), file) >= 0;
  if (std::fclose(file) != 0 || !is_written)
    return report(not_written(options, path, errno), false);
  std::printf("%s\n\nReplace each \"?\", then: weir inspect %s\n", printable_text(path).c_str(),
              shell_word(options.model).c_str());
  return kExitGood;
}

}  // namespace weir::app
