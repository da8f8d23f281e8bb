// Calls a function of a C API with each of its pointers NULL in turn.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <tuple>
#include <type_traits>

namespace weir::test {

// An argument that may be NULL according to its documentation.
template <class T>
struct MayBeNull {
  T value;
};
template <class T>
MayBeNull<T> may_be_null(T value) {
  return {value};
}

template <class T>
inline constexpr bool kMayBeNull = false;
template <class T>
inline constexpr bool kMayBeNull<MayBeNull<T>> = true;
template <class T>
T get_value(T value) {
  return value;
}
template <class T>
T get_value(MayBeNull<T> given) {
  return given.value;
}

// The names of all functions called so far.
inline std::set<std::string>& called_functions() {
  static std::set<std::string> names;
  return names;
}

// The result of a function when one of its pointers is NULL: an int is an error, or for `Harmless`
// the documented 0; a text is "" or NULL.
enum class Outcome { Error, Harmless };

template <class R, class... P, class... A>
void expect_null_is_refused(const char* name, Outcome outcome, R (*function)(P...), A... given) {
  called_functions().insert(name);
  const auto call = [&](std::tuple<P...> arguments, const std::string& what) {
    if constexpr (std::is_void_v<R>) {
      std::apply(function, arguments);
    } else {
      const R result = std::apply(function, arguments);
      if constexpr (std::is_same_v<R, int>) {
        if (outcome == Outcome::Harmless) return;
        EXPECT_LT(result, 0) << name << " with " << what;
      } else if constexpr (std::is_same_v<R, const char*>) {
        EXPECT_STREQ(result ? result : "", "") << name << " with " << what;
      }
    }
  };
  const auto with_null = [&]<size_t I>(std::integral_constant<size_t, I>) {
    using Parameter = std::tuple_element_t<I, std::tuple<P...>>;
    using Given = std::tuple_element_t<I, std::tuple<A...>>;
    if constexpr (std::is_pointer_v<Parameter> && !kMayBeNull<Given>) {
      std::tuple<P...> arguments{get_value(given)...};
      std::get<I>(arguments) = nullptr;
      call(arguments, "argument " + std::to_string(I) + " NULL");
    }
  };
  [&]<size_t... I>(std::index_sequence<I...>) {
    (with_null(std::integral_constant<size_t, I>()), ...);
  }
  (std::index_sequence_for<P...>());
  std::tuple<P...> nothing{get_value(given)...};
  std::apply(
      [](auto&... each) {
        const auto clear = [](auto& argument) {
          if constexpr (std::is_pointer_v<std::remove_reference_t<decltype(argument)>>)
            argument = nullptr;
        };
        (clear(each), ...);
      },
      nothing);
  call(nothing, "every pointer NULL");
}

#define EXPECT_NULL_REFUSED(function, ...) \
  weir::test::expect_null_is_refused(#function, weir::test::Outcome::Error, function, __VA_ARGS__)
#define EXPECT_NULL_HARMLESS(function, ...)                                              \
  weir::test::expect_null_is_refused(#function, weir::test::Outcome::Harmless, function, \
                                     __VA_ARGS__)

}  // namespace weir::test
