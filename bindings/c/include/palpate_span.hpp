/*
 * Non-owning array view for C++17, which has no std::span. With C++20 it converts to and from std::span.
 *
 * License: MIT OR Apache-2.0
 */
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>

#if defined(__has_include)
#if __has_include(<version>)
#include <version>
#endif
#endif
#if defined(__cpp_lib_ranges)
#include <ranges>
#endif

namespace palpate {

template <typename T>
class span;

namespace detail {

/* Whether elements at a `From *` are elements of an array of `To`: the same type, possibly with const added. */
template <typename From, typename To>
inline constexpr bool is_element_v = std::is_convertible_v<From (*)[], To (*)[]>;

template <typename Container>
inline constexpr bool is_span_v = false;
template <typename T>
inline constexpr bool is_span_v<span<T>> = true;

/* Whether `Container` stores its elements in one array of `T`: a vector, a string, a std::span. */
template <typename Container, typename T, typename = void>
inline constexpr bool is_array_of_v = false;
template <typename Container, typename T>
inline constexpr bool is_array_of_v<Container, T,
                                    std::void_t<decltype(std::data(std::declval<Container &>())),
                                                decltype(std::size(std::declval<Container &>()))>> =
    !is_span_v<std::remove_cv_t<Container>> && !std::is_array_v<Container> &&
    is_element_v<std::remove_pointer_t<decltype(std::data(std::declval<Container &>()))>, T>;

}  // namespace detail

/* `size()` elements starting at `data()`. The span owns nothing, so the array must outlive it. Copying it copies no
   element. An empty span may have no array. */
template <typename T>
class span {
 public:
  using element_type = T;
  using value_type = std::remove_cv_t<T>;
  using size_type = std::size_t;
  using difference_type = std::ptrdiff_t;
  using pointer = T *;
  using reference = T &;
  using iterator = T *;

  constexpr span() noexcept = default;

  /* Views `size` elements starting at `data`. */
  constexpr span(T *data, std::size_t size) noexcept : data_(data), size_(size) {}

  /* Views a whole array. */
  template <std::size_t N>
  constexpr span(T (&array)[N]) noexcept : data_(array), size_(N) {}

  /* Views a container that stores its elements in one array: std::array, std::vector, std::span. */
  template <typename Container, std::enable_if_t<detail::is_array_of_v<Container, T>, int> = 0>
  constexpr span(Container &container) noexcept : data_(std::data(container)), size_(std::size(container)) {}

  /* Views a const or temporary container, read-only. */
  template <typename Container, std::enable_if_t<detail::is_array_of_v<const Container, T>, int> = 0>
  constexpr span(const Container &container) noexcept : data_(std::data(container)), size_(std::size(container)) {}

  /* Converts to a read-only view of the same elements. */
  template <typename Other, std::enable_if_t<!std::is_same_v<Other, T> && detail::is_element_v<Other, T>, int> = 0>
  constexpr span(const span<Other> &other) noexcept : data_(other.data()), size_(other.size()) {}

  constexpr T *data() const noexcept { return data_; }
  constexpr std::size_t size() const noexcept { return size_; }
  constexpr bool empty() const noexcept { return size_ == 0; }
  constexpr T *begin() const noexcept { return data_; }
  constexpr T *end() const noexcept { return data_ + size_; }

  /* Returns an element. The index is not checked. */
  constexpr T &operator[](std::size_t place) const noexcept { return data_[place]; }

  /* Returns the first `count` elements; `count` must not exceed size(). */
  constexpr span first(std::size_t count) const noexcept { return span(data_, count); }

  /* Returns the elements starting at `from`; `from` must not exceed size(). */
  constexpr span subspan(std::size_t from) const noexcept { return span(data_ + from, size_ - from); }

 private:
  T *data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace palpate

namespace palpate {
namespace detail {

/* Whether an argument of the deduced type `T &&` is a container that is destroyed at the end of the expression. A view,
   such as a span, owns nothing. */
template <typename T>
inline constexpr bool is_temporary_v =
    !std::is_lvalue_reference_v<T> && !is_span_v<std::remove_cv_t<std::remove_reference_t<T>>>
#if defined(__cpp_lib_ranges)
    && !std::ranges::borrowed_range<T>
#endif
    ;

/* Enables a deleted overload that rejects a temporary container, because the result would point to its elements. */
template <typename... Arrays>
using if_temporary = std::enable_if_t<(is_temporary_v<Arrays> || ...), int>;

}  // namespace detail
}  // namespace palpate

#if defined(__cpp_lib_ranges)
/* A span owns nothing, so a std::span may be made from a temporary one. */
template <typename T>
inline constexpr bool std::ranges::enable_borrowed_range<palpate::span<T>> = true;
#endif
