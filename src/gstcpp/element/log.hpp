// Debug categories: one for each element, named like its factory; "weir" for the library; one for
// each module, "weir-NAME".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

namespace weir::gst {

// Returns the category `name`; the first call creates it and it is never freed. Any thread.
GstDebugCategory* debug_category(const char* name, const char* description);
// "weir": for log lines of no particular element or module.
GstDebugCategory* library_category();
// Registers the category of an element type for get_category(); null: none.
void set_category(GType type, GstDebugCategory* category);
// The category of the element's type; "weir" if it has none.
GstDebugCategory* get_category(GstElement* element);

// Logs, at INFO in the category of the pad's element, the new caps of its stream.
void log_output_caps(GstPad* source_pad, const GstCaps* caps);

// Logs a line of a module or of the library (weir_host::log) in the category "weir-MODULE", or in
// "weir" when `module` is not a module name (lower-case letters, digits, - and _). Errors and
// warnings that GST_DEBUG hides are written to standard error.
void log_module_line(int level, const char* module, const char* text);

}  // namespace weir::gst
