// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/pango_library.hpp"

#include <dlfcn.h>

#include <string>

namespace weir {
namespace {

Error missing(const std::string& offered, const std::string& needed, const std::string& package) {
  return Error{
      .code = Code::FILE_NOT_FOUND,
      .what = "labels cannot be drawn",
      .offered = offered,
      .needed = needed,
      .fix = "apt-get install " + package + "; or tensor_overlay show-scores=false and no labels"};
}

// Never unloaded: fontconfig keeps global state.
Result<PangoLibrary> open() {
  void* const library = dlopen("libpangocairo-1.0.so.0", RTLD_NOW | RTLD_LOCAL);
  const std::string needed = "the libraries Pango and Cairo";
  if (!library) return missing(dlerror(), needed, "libpangocairo-1.0-0");
  PangoLibrary out;
  std::string lacking;
  const auto find = [&](const char* name, auto* function) {
    *function = reinterpret_cast<std::decay_t<decltype(*function)>>(dlsym(library, name));
    if (!*function) lacking = name;
  };
#define WEIR_PANGO_FIND(name) find(#name, &out.name);
  WEIR_PANGO_FUNCTIONS(WEIR_PANGO_FIND)
#undef WEIR_PANGO_FIND
  if (!lacking.empty())
    return missing("a library without " + lacking, needed, "libpangocairo-1.0-0");
  // Pango aborts the process if there are no fonts.
  const FcFontSet* fonts = out.FcConfigGetFonts(out.FcConfigGetCurrent(), FcSetSystem);
  if (!fonts || fonts->nfont == 0) return missing("no font", "a font", "fonts-dejavu-core");
  return out;
}

}  // namespace

const Result<PangoLibrary>& PangoLibrary::instance() {
  static const Result<PangoLibrary> library = open();
  return library;
}

}  // namespace weir
