// PangoLibrary: the functions of Pango, Cairo and fontconfig for labels, loaded at run time: a
// pipeline that draws no text needs neither them nor their memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fontconfig/fontconfig.h>
#include <pango/pangocairo.h>

#include "weir/result.hpp"

namespace weir {

struct PangoLibrary {
  // Loaded once per process. FILE_NOT_FOUND: a library is missing, or there are no fonts.
  static const Result<PangoLibrary>& instance();

#define WEIR_PANGO_FUNCTIONS(X)               \
  X(FcConfigGetCurrent)                       \
  X(FcConfigGetFonts)                         \
  X(cairo_create)                             \
  X(cairo_destroy)                            \
  X(cairo_image_surface_create)               \
  X(cairo_image_surface_get_data)             \
  X(cairo_image_surface_get_stride)           \
  X(cairo_move_to)                            \
  X(cairo_surface_destroy)                    \
  X(cairo_surface_flush)                      \
  X(pango_cairo_font_map_new)                 \
  X(pango_cairo_show_layout)                  \
  X(pango_font_description_free)              \
  X(pango_font_description_from_string)       \
  X(pango_font_description_set_absolute_size) \
  X(pango_font_map_create_context)            \
  X(pango_layout_get_baseline)                \
  X(pango_layout_get_pixel_size)              \
  X(pango_layout_new)                         \
  X(pango_layout_set_ellipsize)               \
  X(pango_layout_set_font_description)        \
  X(pango_layout_set_single_paragraph_mode)   \
  X(pango_layout_set_text)                    \
  X(pango_layout_set_width)
// NOLINTNEXTLINE(bugprone-macro-parentheses): a name that is declared takes none
#define WEIR_PANGO_POINTER(name) decltype(&::name) name = nullptr;
  WEIR_PANGO_FUNCTIONS(WEIR_PANGO_POINTER)
#undef WEIR_PANGO_POINTER
};

}  // namespace weir
