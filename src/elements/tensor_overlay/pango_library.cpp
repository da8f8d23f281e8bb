// Opens what is there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/pango_library.hpp"

#include <dlfcn.h>

#include <string>

namespace weir {
namespace {

Error missing(const std::string& offered, const std::string& needed, const std::string& package) {
  return Error{
      Code::FILE_NOT_FOUND,
      "labels cannot be drawn",
      offered,
      needed,
      "",
      "apt-get install " + package + "; or tensor_overlay show-scores=false and no labels"};
}

// The library stays for as long as the process does: fontconfig keeps what it found.
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
  // Pango ends the process when there is none.
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
