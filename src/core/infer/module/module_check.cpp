// Validates tables without reading beyond their struct_size.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_check.hpp"

#include <cstddef>
#include <string_view>

#include "core/text/shell_quote.hpp"

namespace weir::infer {
namespace {

std::string format_version(uint16_t major) {
  return "ABI version " + std::to_string(major);
}

// Every kind of table begins with size, version and name. It must have `needed` bytes.
template <class Table>
Status check_head(const Table& table, const char* kind, size_t needed, const std::string& path) {
  if (table.struct_size < needed)
    return module_refused(
        path,
        std::string(kind) + " with a table of " + std::to_string(table.struct_size) + " bytes",
        "at least " + std::to_string(needed));
  if (table.abi_major != WEIR_ABI_MAJOR)
    return module_refused(path, std::string(kind) + " of " + format_version(table.abi_major),
                          format_version(WEIR_ABI_MAJOR));
  if (!table.name || !*table.name)
    return module_refused(path, std::string(kind) + " without a name", "a name");
  return ok();
}

Status missing(const char* kind, const char* name, const std::string& path, bool complete,
               const char* functions) {
  if (complete) return ok();
  return module_refused(path, std::string(kind) + " " + name + " without all of its functions",
                        functions);
}

Status check(const weir_engine& engine, const std::string& path) {
  if (auto s = check_head(engine, "an engine", offsetof(weir_engine, submit), path); !s) return s;
  return missing("the engine", engine.name, path,
                 engine.open && engine.close && engine.info && engine.session_new &&
                     engine.session_free && engine.invoke,
                 "open, close, info, session_new, session_free, invoke");
}

Status check(const weir_decoder_type& decoder, const std::string& path) {
  if (auto s = check_head(decoder, "a decoder", offsetof(weir_decoder_type, extension), path); !s)
    return s;
  return missing("the decoder", decoder.name, path,
                 decoder.open && decoder.close && decoder.configure && decoder.decode,
                 "open, close, configure, decode");
}

Status check(const weir_converter_type& converter, const std::string& path) {
  if (auto s = check_head(converter, "a converter", offsetof(weir_converter_type, extension), path);
      !s)
    return s;
  return missing("the converter", converter.name, path,
                 converter.open && converter.close && converter.configure && converter.convert,
                 "open, close, configure, convert");
}

template <class Table>
Status check_all(const Table* const* tables, const std::string& path) {
  for (; tables && *tables; ++tables)
    if (auto status = check(**tables, path); !status) return status;
  return ok();
}

}  // namespace

Error module_refused(const std::string& path, std::string offered, std::string needed) {
  return Error{.code = Code::MODULE_REFUSED,
               .what = "the module " + path + " cannot be used",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "build the module again with the headers of this version of Weir"};
}

Error module_not_loaded(const std::string& path, const char* reason) {
  const std::string_view message = reason ? reason : "dlopen failed";
  const size_t end = message.find(": cannot open shared object file");
  const std::string_view library = message.substr(0, end);
  if (end == std::string_view::npos || library == path)
    return module_refused(path, std::string(message), "a shared object for this machine");
  return Error{.code = Code::MODULE_REFUSED,
               .what = "a library that " + path + " needs is missing",
               .offered = std::string(message),
               .needed = std::string(library) + ", in a folder that the loader searches",
               .fix = "ldd " + shell_word(path) +
                      " shows what is missing: install it, or export LD_LIBRARY_PATH=/its/folder"};
}

Status check_module(const weir_module* module, const std::string& path) {
  if (!module)
    return module_refused(path, "weir_module_entry returned NULL",
                          "its tables; the reason is in the log");
  if (module->abi_major != WEIR_ABI_MAJOR)
    return module_refused(path, format_version(module->abi_major), format_version(WEIR_ABI_MAJOR));
  if (module->struct_size < offsetof(weir_module, trainers))
    return module_refused(path, "a table of " + std::to_string(module->struct_size) + " bytes",
                          "at least " + std::to_string(offsetof(weir_module, trainers)));
  if (auto status = check_all(module->engines, path); !status) return status;
  if (auto status = check_all(module->decoders, path); !status) return status;
  return check_all(module->converters, path);
}

}  // namespace weir::infer
