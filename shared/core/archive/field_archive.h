// FieldWriter, FieldReader: write numbers, lists and structs one after the other, and read them
// again. Both take the same list of fields, so that one function serves both directions.
#pragma once

#include "shared/core/archive/aggregate_fields.h"
#include "shared/core/ids.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace zoned::core {

/// A number as an unsigned one of the same size.
template <class Number>
auto bits_of(Number number) {
    if constexpr (std::is_same_v<Number, float>) {
        return std::bit_cast<std::uint32_t>(number);
    } else if constexpr (std::is_same_v<Number, double>) {
        return std::bit_cast<std::uint64_t>(number);
    } else if constexpr (std::is_same_v<Number, bool>) {
        return static_cast<std::uint8_t>(number);
    } else if constexpr (std::is_enum_v<Number>) {
        return static_cast<std::make_unsigned_t<std::underlying_type_t<Number>>>(number);
    } else {
        return static_cast<std::make_unsigned_t<Number>>(number);
    }
}

template <class T>
struct OfTemplate : std::false_type {};

template <class Tag, class Rep>
struct OfTemplate<StrongId<Tag, Rep>> : std::true_type {};

template <class T>
inline constexpr bool kIsStrongId = OfTemplate<T>::value;

/// Matrices, vectors and arrays of fixed size of Eigen, which stands below no folder of its own.
template <class T>
concept FixedMatrix = requires(T& t) {
    typename T::Scalar;
    requires int(T::SizeAtCompileTime) > 0;
    { t.data() } -> std::same_as<typename T::Scalar*>;
};

template <class T>
concept Quaternion = requires(T& t) {
    typename T::Coefficients;
    t.coeffs();
    t.vec();
};

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Whether a class lists its own fields: a member `serialize(archive)`, which may be private to all
/// but a friend, or a function of its namespace.
template <class T, class Archive>
concept ListsItsFields = requires(T& t, Archive& archive) {
    t.serialize(archive);
};

template <class T, class Archive>
concept FieldsAreListed = requires(T& t, Archive& archive) {
    serialize(archive, t);
};

class FieldWriter;

template <class T>
constexpr bool is_dense();

struct DenseFields {
    template <class... Field>
    constexpr auto operator()(const Field&... /*fields*/) const {
        return std::integral_constant < std::size_t,
               (is_dense<Field>() && ...) ? (sizeof(Field) + ...) : 0 > ();
    }
};

/// The bytes of a T are its fields and nothing else, and any bytes are a T.
template <class T>
constexpr bool is_dense() {
    if constexpr (std::is_same_v<T, bool>) {
        return false;
    } else if constexpr (Number<T> || kIsStrongId<T>) {
        return true;
    } else if constexpr (ListsItsFields<T, FieldWriter> || FieldsAreListed<T, FieldWriter>) {
        return false;
    } else if constexpr (FixedMatrix<T>) {
        return sizeof(T) == sizeof(typename T::Scalar) * std::size_t(T::SizeAtCompileTime);
    } else if constexpr (Quaternion<T>) {
        return sizeof(T) == 4 * sizeof(typename T::Scalar);
    } else if constexpr (std::is_aggregate_v<T> && requires { std::tuple_size<T>::value; }) {
        return is_dense<typename T::value_type>();
    } else if constexpr (std::is_aggregate_v<T> && std::is_trivially_copyable_v<T>) {
        return decltype(with_fields(std::declval<T&>(), DenseFields()))::value == sizeof(T);
    } else {
        return false;
    }
}

/// Facts that types deep within the state need while they are written or read, by their type: say
/// the geometries that shapes share.
class ArchiveLoans {
  public:
    /// In place of what was lent of this type before: each zone lends its own.
    template <class T>
    void lend(T& value) {
        std::erase_if(loans_, [](const auto& loan) { return loan.first == tag_of<T>(); });
        loans_.emplace_back(tag_of<T>(), &value);
    }

    template <class T>
    [[nodiscard]] T& lent() const {
        const auto it = std::find_if(loans_.begin(), loans_.end(), [](const auto& loan) {
            return loan.first == tag_of<T>();
        });
        return *static_cast<T*>(it->second);
    }

  private:
    template <class T>
    static const void* tag_of() {
        static constexpr char kTag = 0;
        return &kTag;
    }

    std::vector<std::pair<const void*, void*>> loans_;
};

/// The place of a named part in the bytes, for tests and sizes.
struct ArchiveSection {
    std::string name;
    std::size_t begin = 0;
    std::size_t end = 0;
};

/// Appends numbers (little endian, floats by their bits), lists after their lengths, and the fields
/// of structs.
class FieldWriter : public ArchiveLoans {
  public:
    static constexpr bool kReads = false;

    explicit FieldWriter(std::vector<std::uint8_t>& out) : out_(&out) {}

    template <class... Values>
    void operator()(const Values&... values) {
        (put(values), ...);
    }

    /// Something has no saved form: the bytes are not to be used, and the text says why.
    void fail(std::string reason) {
        if (wrong_.empty()) {
            wrong_ = places_ + reason;
        }
    }

    /// Empty: nothing went wrong.
    [[nodiscard]] const std::string& wrong() const { return wrong_; }

    [[nodiscard]] bool good() const { return wrong_.empty(); }

    /// A part with a name and a length, so that errors name the place.
    template <class Work>
    void section(std::string_view name, Work&& work) {
        const std::string before = places_;
        places_ += std::string(name) + ": ";
        put(std::uint64_t{0});
        const std::size_t from = out_->size();
        work();
        const std::uint64_t length = out_->size() - from;
        for (std::size_t b = 0; b < sizeof(length); ++b) {
            (*out_)[from - sizeof(length) + b] = static_cast<std::uint8_t>(length >> (8U * b));
        }
        sections_.push_back({places_, from, out_->size()});
        places_ = before;
    }

    /// Inner parts before outer ones.
    [[nodiscard]] const std::vector<ArchiveSection>& sections() const { return sections_; }

    /// So many items without their number.
    template <class T>
    void items(const T* first, std::size_t count) {
        put_all(first, count);
    }

    void bytes(std::span<const std::uint8_t> some) {
        put(static_cast<std::uint64_t>(some.size()));
        out_->insert(out_->end(), some.begin(), some.end());
    }

  private:
    void raw(const void* from, std::size_t size) {
        const std::size_t at = out_->size();
        out_->resize(at + size);
        std::memcpy(out_->data() + at, from, size);
    }

    template <class T>
    void put_all(const T* first, std::size_t count) {
        if constexpr (is_dense<T>() && std::endian::native == std::endian::little) {
            if (count > 0) {
                raw(first, count * sizeof(T));
            }
        } else {
            for (std::size_t i = 0; i < count; ++i) {
                put(first[i]);
            }
        }
    }

    template <class T>
    void put_list(const T& list) {
        put(static_cast<std::uint64_t>(list.size()));
        for (const auto& item : list) {
            put(item);
        }
    }

    template <class T>
    void put(const T& value) {
        static_assert(!std::is_pointer_v<T>, "a pointer has no saved form");
        if constexpr (Number<T>) {
            const auto bits = bits_of(value);
            if constexpr (std::endian::native == std::endian::little) {
                raw(&bits, sizeof(bits));
            } else {
                for (std::size_t b = 0; b < sizeof(bits); ++b) {
                    out_->push_back(static_cast<std::uint8_t>(bits >> (8U * b)));
                }
            }
        } else if constexpr (kIsStrongId<T>) {
            put(value.value);
        } else if constexpr (ListsItsFields<T, FieldWriter>) {
            const_cast<T&>(value).serialize(*this);  // writing leaves it as it is
        } else if constexpr (FieldsAreListed<T, FieldWriter>) {
            serialize(*this, const_cast<T&>(value));
        } else if constexpr (FixedMatrix<T>) {
            put_all(value.data(), std::size_t(T::SizeAtCompileTime));
        } else if constexpr (Quaternion<T>) {
            put_all(value.coeffs().data(), 4);
        } else if constexpr (std::is_aggregate_v<T> && requires { std::tuple_size<T>::value; }) {
            put_all(value.data(), value.size());
        } else if constexpr (std::is_aggregate_v<T>) {
            if constexpr (is_dense<T>() && std::endian::native == std::endian::little) {
                raw(&value, sizeof(T));
            } else {
                with_fields(value, [&](const auto&... field) { (put(field), ...); });
            }
        } else {
            put_container(value);
        }
    }

    template <class T>
    void put_container(const std::vector<T>& list) {
        put(static_cast<std::uint64_t>(list.size()));
        put_all(list.data(), list.size());
    }

    void put_container(const std::vector<bool>& list) = delete;

    template <class T>
    void put_container(const std::deque<T>& list) {
        put_list(list);
    }

    template <class K, class V, class C>
    void put_container(const std::map<K, V, C>& map) {
        put_list(map);
    }

    template <class K, class C>
    void put_container(const std::set<K, C>& set) {
        put_list(set);
    }

    void put_container(const std::string& text) {
        put(static_cast<std::uint64_t>(text.size()));
        raw(text.data(), text.size());
    }

    template <class A, class B>
    void put_container(const std::pair<A, B>& both) {
        put(both.first);
        put(both.second);
    }

    template <class T>
    void put_container(const std::optional<T>& value) {
        put(value.has_value());
        if (value) {
            put(*value);
        }
    }

    template <class T>
    void put_container(const std::unique_ptr<T>& value) {
        put(value != nullptr);
        if (value) {
            put(*value);
        }
    }

    std::vector<std::uint8_t>* out_;
    std::string places_;
    std::string wrong_;
    std::vector<ArchiveSection> sections_;
};

/// Reads the output of FieldWriter. Bytes are hostile: beyond their end, and after the first fault,
/// all numbers are 0 and all lists empty.
class FieldReader : public ArchiveLoans {
  public:
    static constexpr bool kReads = true;

    explicit FieldReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    template <class... Values>
    void operator()(Values&... values) {
        (get(values), ...);
    }

    [[nodiscard]] bool cut_short() const { return short_; }

    /// Whether all floats so far were finite.
    [[nodiscard]] bool finite() const { return finite_; }

    /// Whether all booleans so far were 0 or 1.
    [[nodiscard]] bool known() const { return known_; }

    [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

    /// The bytes are of no use, and the text says why; the first reason counts.
    void fail(std::string reason) {
        if (wrong_.empty()) {
            wrong_ = places_ + reason;
        }
        at_ = bytes_.size();
    }

    /// Empty: nothing went wrong.
    [[nodiscard]] const std::string& wrong() const { return wrong_; }

    [[nodiscard]] bool good() const { return wrong_.empty(); }

    template <class Work>
    void section(std::string_view name, Work&& work) {
        const std::string before = places_;
        places_ += std::string(name) + ": ";
        std::uint64_t length = 0;
        get(length);
        if (length > left()) {
            fail("is cut short");
        } else {
            const std::span<const std::uint8_t> all = bytes_;
            const std::size_t end = at_ + static_cast<std::size_t>(length);
            bytes_ = all.first(end);
            work();
            if (good() && at_ != end) {
                fail(std::to_string(end - at_) + " bytes are left over");
            }
            bytes_ = all;
            at_ = good() ? end : all.size();
        }
        places_ = before;
    }

    template <class T>
    void items(T* first, std::size_t count) {
        get_all(first, count);
    }

    /// The content of FieldWriter::bytes.
    [[nodiscard]] std::span<const std::uint8_t> bytes() {
        const std::size_t size = count(1);
        const std::span<const std::uint8_t> some = bytes_.subspan(at_, size);
        at_ += size;
        return some;
    }

  private:
    [[nodiscard]] bool take(void* to, std::size_t size) {
        if (left() < size) {
            short_ = true;
            fail("is cut short");
            return false;
        }
        if (size > 0) {
            std::memcpy(to, bytes_.data() + at_, size);
        }
        at_ += size;
        return true;
    }

    /// A length of a list whose items take so many bytes or more.
    [[nodiscard]] std::size_t count(std::size_t least_bytes) {
        std::uint64_t size = 0;
        get(size);
        if (size > left() / least_bytes) {
            short_ = true;
            fail("a list is longer than its bytes");
            return 0;
        }
        return static_cast<std::size_t>(size);
    }

    template <class T>
    void get_all(T* first, std::size_t size) {
        if constexpr (is_dense<T>() && std::endian::native == std::endian::little) {
            static_cast<void>(take(static_cast<void*>(first), size * sizeof(T)));
        } else {
            for (std::size_t i = 0; i < size; ++i) {
                get(first[i]);
            }
        }
    }

    template <class T>
    void get_number(T& number) {
        using Bits = decltype(bits_of(number));
        Bits bits = 0;
        if (left() < sizeof(Bits)) {
            short_ = true;
            fail("is cut short");
            number = T{};
            return;
        }
        if constexpr (std::endian::native == std::endian::little) {
            std::memcpy(&bits, bytes_.data() + at_, sizeof(bits));
            at_ += sizeof(bits);
        } else {
            for (std::size_t b = 0; b < sizeof(Bits); ++b) {
                bits = static_cast<Bits>(bits | static_cast<Bits>(bytes_[at_++]) << (8U * b));
            }
        }
        if constexpr (std::is_floating_point_v<T>) {
            number = std::bit_cast<T>(bits);
            finite_ = finite_ && std::isfinite(number);
        } else if constexpr (std::is_same_v<T, bool>) {
            known_ = known_ && bits <= 1;
            number = bits != 0;
        } else {
            number = static_cast<T>(bits);
        }
    }

    template <class T>
    void get(T& value) {
        static_assert(!std::is_pointer_v<T>, "a pointer has no saved form");
        if constexpr (Number<T>) {
            get_number(value);
        } else if constexpr (kIsStrongId<T>) {
            get_number(value.value);
        } else if constexpr (ListsItsFields<T, FieldReader>) {
            value.serialize(*this);
        } else if constexpr (FieldsAreListed<T, FieldReader>) {
            serialize(*this, value);
        } else if constexpr (FixedMatrix<T>) {
            get_all(value.data(), std::size_t(T::SizeAtCompileTime));
        } else if constexpr (Quaternion<T>) {
            get_all(value.coeffs().data(), 4);
        } else if constexpr (std::is_aggregate_v<T> && requires { std::tuple_size<T>::value; }) {
            get_all(value.data(), value.size());
        } else if constexpr (std::is_aggregate_v<T>) {
            if constexpr (is_dense<T>() && std::endian::native == std::endian::little) {
                static_cast<void>(take(&value, sizeof(T)));
            } else {
                with_fields(value, [&](auto&... field) { (get(field), ...); });
            }
        } else {
            get_container(value);
        }
    }

    template <class T>
    void get_container(std::vector<T>& list) {
        if constexpr (is_dense<T>() && std::endian::native == std::endian::little) {
            list.resize(count(sizeof(T)));
            get_all(list.data(), list.size());
        } else {
            // One after the other: a wrong length takes no more memory than there are bytes for.
            const std::size_t size = count(1);
            list.clear();
            for (std::size_t i = 0; i < size && good(); ++i) {
                get(list.emplace_back());
            }
        }
    }

    template <class T>
    void get_container(std::deque<T>& list) {
        const std::size_t size = count(1);
        list.clear();
        for (std::size_t i = 0; i < size && good(); ++i) {
            get(list.emplace_back());
        }
    }

    template <class K, class V, class C>
    void get_container(std::map<K, V, C>& map) {
        const std::size_t size = count(1);
        map.clear();
        for (std::size_t i = 0; i < size && good(); ++i) {
            K key{};
            get(key);
            if (!map.empty() && !map.key_comp()(std::prev(map.end())->first, key)) {
                fail("keys are in no order");
                return;
            }
            get(map.emplace_hint(map.end(), std::move(key), V{})->second);
        }
    }

    template <class K, class C>
    void get_container(std::set<K, C>& set) {
        const std::size_t size = count(1);
        set.clear();
        for (std::size_t i = 0; i < size && good(); ++i) {
            K key{};
            get(key);
            if (!set.empty() && !set.key_comp()(*std::prev(set.end()), key)) {
                fail("keys are in no order");
                return;
            }
            set.insert(set.end(), std::move(key));
        }
    }

    void get_container(std::string& text) {
        text.resize(count(1));
        static_cast<void>(take(text.data(), text.size()));
    }

    template <class A, class B>
    void get_container(std::pair<A, B>& both) {
        get(both.first);
        get(both.second);
    }

    template <class T>
    void get_container(std::optional<T>& value) {
        bool there = false;
        get(there);
        value.reset();
        if (there) {
            get(value.emplace());
        }
    }

    template <class T>
    void get_container(std::unique_ptr<T>& value) {
        bool there = false;
        get(there);
        value = there ? std::make_unique<T>() : nullptr;
        if (there) {
            get(*value);
        }
    }

    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
    bool short_ = false;
    bool finite_ = true;
    bool known_ = true;
    std::string places_;
    std::string wrong_;
};

}  // namespace zoned::core
