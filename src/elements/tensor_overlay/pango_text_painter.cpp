// Paints label texts with one reused Pango layout.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "elements/tensor_overlay/pango_library.hpp"
#include "elements/tensor_overlay/text_painter.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

constexpr char kFont[] = "Sans Bold";
constexpr uint32_t kWidest = 30;  // maximal text width, in font sizes; the rest becomes an ellipsis

template <class T>
using Object = gst::Unique<T, g_object_unref>;

class PangoTextPainter : public draw::TextPainter {
 public:
  PangoTextPainter(const PangoLibrary& library, uint32_t size)
      : p_(library),
        fonts_(p_.pango_cairo_font_map_new()),
        context_(p_.pango_font_map_create_context(fonts_.get())),
        layout_(p_.pango_layout_new(context_.get())),
        widest_(static_cast<int>(kWidest * size)) {
    PangoFontDescription* font = p_.pango_font_description_from_string(kFont);
    p_.pango_font_description_set_absolute_size(font, static_cast<double>(size) * PANGO_SCALE);
    p_.pango_layout_set_font_description(layout_.get(), font);
    p_.pango_font_description_free(font);
    p_.pango_layout_set_single_paragraph_mode(layout_.get(), TRUE);
    p_.pango_layout_set_width(layout_.get(), widest_ * PANGO_SCALE);
    p_.pango_layout_set_ellipsize(layout_.get(), PANGO_ELLIPSIZE_END);
    p_.pango_layout_set_text(layout_.get(), "Ag", -1);
    p_.pango_layout_get_pixel_size(layout_.get(), nullptr, &height_);
    baseline_ = p_.pango_layout_get_baseline(layout_.get());
  }

  // Fallback fonts of other scripts may have another height: their baseline is aligned with ours.
  draw::Mask paint(const std::string& text) override {
    p_.pango_layout_set_text(layout_.get(), text.data(), static_cast<int>(text.size()));
    int width = 0;
    p_.pango_layout_get_pixel_size(layout_.get(), &width, nullptr);
    width = std::clamp(width, 0, widest_);
    draw::Mask out{static_cast<uint32_t>(width), static_cast<uint32_t>(height_), {}};
    out.coverage.resize(size_t{out.width} * out.height);
    cairo_surface_t* surface = p_.cairo_image_surface_create(CAIRO_FORMAT_A8, width, height_);
    cairo_t* cairo = p_.cairo_create(surface);
    const int down = baseline_ - p_.pango_layout_get_baseline(layout_.get());
    p_.cairo_move_to(cairo, 0, static_cast<double>(down) / PANGO_SCALE);
    p_.pango_cairo_show_layout(cairo, layout_.get());
    p_.cairo_destroy(cairo);
    p_.cairo_surface_flush(surface);
    // Null when memory ran out or there is nothing to paint.
    if (const uint8_t* row = p_.cairo_image_surface_get_data(surface))
      for (size_t y = 0; y < out.height; ++y) {
        std::copy_n(row, out.width, out.coverage.begin() + static_cast<ptrdiff_t>(y * out.width));
        row += p_.cairo_image_surface_get_stride(surface);
      }
    p_.cairo_surface_destroy(surface);
    return out;
  }

 private:
  const PangoLibrary& p_;
  Object<PangoFontMap> fonts_;
  Object<PangoContext> context_;
  Object<PangoLayout> layout_;
  const int widest_;  // pixels
  int height_ = 0;    // pixels
  int baseline_ = 0;  // Pango units
};

}  // namespace

Result<std::unique_ptr<draw::TextPainter>> make_text_painter(uint32_t size) {
  const auto& library = PangoLibrary::instance();
  if (!library) return library.error();
  return std::unique_ptr<draw::TextPainter>(std::make_unique<PangoTextPainter>(*library, size));
}

}  // namespace weir
