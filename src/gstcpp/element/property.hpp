// Describes an element's properties as a table of names, values and help texts.
//
// Property: a field of the element's Settings; its default is the field's initialiser.
// ReadOnly: a method of the element. Accessor: a field for writing and a method of the same type
// for reading. Gauge: the same for an integer whose field enables the number that the method
// returns.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// When a property may be written; shown by gst-inspect-1.0.
enum class Changeable : int {
  InReady = GST_PARAM_MUTABLE_READY,
  WhilePlaying = GST_PARAM_MUTABLE_PLAYING,
};

// Bounds of numbers. Other properties have none; the members must stay constant expressions.
template <class T>
using Bound = std::conditional_t<std::is_arithmetic_v<T>, T, int>;

template <class S, class T>
struct Property {
  const char* name;
  T S::*field;
  const char* blurb;
  Changeable changeable = Changeable::InReady;
  Bound<T> min = std::numeric_limits<Bound<T>>::lowest();
  Bound<T> max = std::numeric_limits<Bound<T>>::max();
};
template <class Impl, class T>
struct ReadOnly {
  const char* name;
  T (Impl::*get)() const;
  const char* blurb;
};
template <class S, class Impl, class T>
struct Accessor {
  const char* name;
  T S::*field;
  T (Impl::*get)() const;
  const char* blurb;
  Changeable changeable = Changeable::InReady;
};
template <class S, class Impl>
struct Gauge {
  const char* name;
  int S::*field;
  int (Impl::*get)() const;
  const char* blurb;
  int min, max;
};

// clang < 17 cannot deduce the template arguments of an aggregate.
template <class S, class T>
Property(const char*, T S::*, const char*) -> Property<S, T>;
template <class S, class T>
Property(const char*, T S::*, const char*, Changeable) -> Property<S, T>;
template <class S, class T, class U>
Property(const char*, T S::*, const char*, Changeable, U, U) -> Property<S, T>;
template <class Impl, class T>
ReadOnly(const char*, T (Impl::*)() const, const char*) -> ReadOnly<Impl, T>;
template <class S, class Impl, class T>
Accessor(const char*, T S::*, T (Impl::*)() const, const char*) -> Accessor<S, Impl, T>;
template <class S, class Impl, class T>
Accessor(const char*, T S::*, T (Impl::*)() const, const char*, Changeable) -> Accessor<S, Impl, T>;
template <class S, class Impl>
Gauge(const char*, int S::*, int (Impl::*)() const, const char*, int, int) -> Gauge<S, Impl>;

// Specialise for each enum used as a property: `static GType type()`, registered once.
template <class T>
struct EnumType;
// The same for an enum whose values are flags.
template <class T>
struct FlagsType;
template <class T>
concept Flags = std::is_enum_v<T> && requires {
  FlagsType<T>::type();
};

template <class T>
void to_gvalue(const T& v, GValue* out) {
  if constexpr (Flags<T>)
    g_value_set_flags(out, static_cast<guint>(v));
  else if constexpr (std::is_enum_v<T>)
    g_value_set_enum(out, static_cast<int>(v));
  else if constexpr (std::is_same_v<T, bool>)
    g_value_set_boolean(out, v);
  else if constexpr (std::is_same_v<T, int>)
    g_value_set_int(out, v);
  else if constexpr (std::is_same_v<T, uint32_t>)
    g_value_set_uint(out, v);
  else if constexpr (std::is_same_v<T, uint64_t>)
    g_value_set_uint64(out, v);
  else if constexpr (std::is_same_v<T, int64_t>)
    g_value_set_int64(out, v);
  else if constexpr (std::is_same_v<T, float>)
    g_value_set_float(out, v);
  else if constexpr (std::is_same_v<T, std::optional<std::string>>)
    g_value_set_string(out, v ? v->c_str() : nullptr);
  else if constexpr (std::is_same_v<T, GstStructure*>)
    g_value_take_boxed(out, v);
  else if constexpr (std::is_same_v<T, Ref<GstPad>>)
    g_value_set_object(out, v.get());
  else if constexpr (std::is_same_v<T, Ref<GstCaps>>)
    gst_value_set_caps(out, v.get());
  else
    g_value_set_string(out, v.c_str());
}

template <class T>
T from_gvalue(const GValue* in) {
  if constexpr (Flags<T>) {
    return static_cast<T>(g_value_get_flags(in));
  } else if constexpr (std::is_enum_v<T>) {
    return static_cast<T>(g_value_get_enum(in));
  } else if constexpr (std::is_same_v<T, bool>) {
    return g_value_get_boolean(in);
  } else if constexpr (std::is_same_v<T, int>) {
    return g_value_get_int(in);
  } else if constexpr (std::is_same_v<T, uint32_t>) {
    return g_value_get_uint(in);
  } else if constexpr (std::is_same_v<T, uint64_t>) {
    return g_value_get_uint64(in);
  } else if constexpr (std::is_same_v<T, int64_t>) {
    return g_value_get_int64(in);
  } else if constexpr (std::is_same_v<T, float>) {
    return g_value_get_float(in);
  } else if constexpr (std::is_same_v<T, Ref<GstCaps>>) {
    return T::share(static_cast<GstCaps*>(g_value_get_boxed(in)));
  } else {
    const char* s = g_value_get_string(in);
    if constexpr (std::is_same_v<T, std::optional<std::string>>)
      return s ? std::optional<std::string>(s) : std::nullopt;
    else
      return s ? s : "";
  }
}

template <class T>
GParamSpec* value_spec(const char* name, const char* blurb, [[maybe_unused]] Bound<T> min,
                       [[maybe_unused]] Bound<T> max, [[maybe_unused]] const T& def,
                       GParamFlags flags) {
  if constexpr (Flags<T>)
    return g_param_spec_flags(name, name, blurb, FlagsType<T>::type(), static_cast<guint>(def),
                              flags);
  else if constexpr (std::is_enum_v<T>)
    return g_param_spec_enum(name, name, blurb, EnumType<T>::type(), static_cast<int>(def), flags);
  else if constexpr (std::is_same_v<T, bool>)
    return g_param_spec_boolean(name, name, blurb, def, flags);
  else if constexpr (std::is_same_v<T, int>)
    return g_param_spec_int(name, name, blurb, min, max, def, flags);
  else if constexpr (std::is_same_v<T, uint32_t>)
    // An out-of-range default means "not set"; GObject requires one within the range.
    return g_param_spec_uint(name, name, blurb, min, max, std::clamp(def, min, max), flags);
  else if constexpr (std::is_same_v<T, uint64_t>)
    return g_param_spec_uint64(name, name, blurb, min, max, def, flags);
  else if constexpr (std::is_same_v<T, int64_t>)
    return g_param_spec_int64(name, name, blurb, min, max, def, flags);
  else if constexpr (std::is_same_v<T, float>)
    return g_param_spec_float(name, name, blurb, min, max, def, flags);
  else if constexpr (std::is_same_v<T, std::optional<std::string>>)
    return g_param_spec_string(name, name, blurb, def ? def->c_str() : nullptr, flags);
  else if constexpr (std::is_same_v<T, GstStructure*>)
    return g_param_spec_boxed(name, name, blurb, GST_TYPE_STRUCTURE, flags);
  else if constexpr (std::is_same_v<T, Ref<GstPad>>)
    return g_param_spec_object(name, name, blurb, GST_TYPE_PAD, flags);
  else if constexpr (std::is_same_v<T, Ref<GstCaps>>)
    return g_param_spec_boxed(name, name, blurb, GST_TYPE_CAPS, flags);
  else
    return g_param_spec_string(name, name, blurb, def.c_str(), flags);
}

inline GParamFlags writable_flags(Changeable changeable) {
  return GParamFlags(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS | static_cast<int>(changeable));
}
template <class S, class T>
GParamSpec* param_spec(const Property<S, T>& p) {
  return value_spec<T>(p.name, p.blurb, p.min, p.max, S{}.*p.field, writable_flags(p.changeable));
}
template <class Impl, class T>
GParamSpec* param_spec(const ReadOnly<Impl, T>& p) {
  return value_spec<T>(p.name, p.blurb, std::numeric_limits<Bound<T>>::lowest(),
                       std::numeric_limits<Bound<T>>::max(), T{},
                       GParamFlags(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS));
}
template <class S, class Impl, class T>
GParamSpec* param_spec(const Accessor<S, Impl, T>& p) {
  return param_spec(Property{p.name, p.field, p.blurb, p.changeable});
}
template <class S, class Impl>
GParamSpec* param_spec(const Gauge<S, Impl>& p) {
  return g_param_spec_int(p.name, p.name, p.blurb, p.min, p.max, p.min,
                          writable_flags(Changeable::WhilePlaying));
}

}  // namespace weir::gst
