// Archives: write, read and hash records field by field, as compact bytes. They
// travel between zones and are kept short; snapshots use numbers of fixed width
// (shared/core/archive/field_archive.h).
#pragma once

#include "server/rules/records.h"
#include "shared/core/state_hash.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <type_traits>

namespace zoned::rules {

/// Integers as LEB128 (signed ones zigzag), floats as their bits, texts and lists after their
/// length.
class Writer {
  public:
    explicit Writer(std::vector<std::uint8_t>& out) : out_(out) {}

    template <class T>
        requires std::is_unsigned_v<T>

    void operator()(const T& value) { varint(static_cast<std::uint64_t>(value)); }

    void operator()(const Tick& tick) {
        varint((static_cast<std::uint64_t>(tick) << 1) ^ static_cast<std::uint64_t>(tick >> 63));
    }

    template <class Tag, class Rep>
    void operator()(const StrongId<Tag, Rep>& id) {
        varint(id.value);
    }

    void operator()(const Life& life) { varint(static_cast<std::uint64_t>(life)); }

    void operator()(const Keeping& keeping) { varint(static_cast<std::uint64_t>(keeping)); }

    void operator()(const Vec3d& v) {
        for (int axis = 0; axis < 3; ++axis) {
            bits(std::bit_cast<std::uint64_t>(v[axis]), 8);
        }
    }

    void operator()(const Vec3& v) {
        for (int axis = 0; axis < 3; ++axis) {
            bits(std::bit_cast<std::uint32_t>(v[axis]), 4);
        }
    }

    void operator()(const std::string& text) {
        varint(text.size());
        out_.insert(out_.end(), text.begin(), text.end());
    }

    template <class T>
    void operator()(const std::vector<T>& items) {
        varint(items.size());
        for (const T& item : items) {
            T::fields(*this, item);
        }
    }

  private:
    void varint(std::uint64_t value) {
        while (value >= 0x80) {
            out_.push_back(static_cast<std::uint8_t>(value | 0x80));
            value >>= 7;
        }
        out_.push_back(static_cast<std::uint8_t>(value));
    }

    void bits(std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i) {
            out_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
        }
    }

    std::vector<std::uint8_t>& out_;
};

/// Reads the output of Writer. After the first fault `ok()` is false and all further values are
/// zero.
class ArchiveReader {
  public:
    static constexpr std::size_t kMaxText = 256;
    static constexpr std::size_t kMaxItems = 64;

    explicit ArchiveReader(std::span<const std::uint8_t> in) : in_(in) {}

    [[nodiscard]] bool ok() const { return ok_; }

    /// True when all was well and nothing is left over.
    [[nodiscard]] bool done() const { return ok_ && in_.empty(); }

    template <class T>
        requires std::is_unsigned_v<T>

    void operator()(T& value) {
        const std::uint64_t wide = varint();
        value = static_cast<T>(wide);
        check(value == wide);
    }

    void operator()(Tick& tick) {
        const std::uint64_t zigzag = varint();
        tick = static_cast<Tick>((zigzag >> 1) ^ (0 - (zigzag & 1)));
    }

    template <class Tag, class Rep>
    void operator()(StrongId<Tag, Rep>& id) {
        (*this)(id.value);
    }

    void operator()(Life& life) {
        const std::uint64_t value = varint();
        check(value <= static_cast<std::uint64_t>(kLastLife));
        life = ok_ ? static_cast<Life>(value) : Life::kAlive;
    }

    void operator()(Keeping& keeping) {
        const std::uint64_t value = varint();
        check(value <= static_cast<std::uint64_t>(kLastKeeping));
        keeping = ok_ ? static_cast<Keeping>(value) : Keeping::kNothing;
    }

    void operator()(Vec3d& v) {
        for (int axis = 0; axis < 3; ++axis) {
            v[axis] = std::bit_cast<double>(bits(8));
        }
        check(v.allFinite());
    }

    void operator()(Vec3& v) {
        for (int axis = 0; axis < 3; ++axis) {
            v[axis] = std::bit_cast<float>(static_cast<std::uint32_t>(bits(4)));
        }
        check(v.allFinite());
    }

    void operator()(std::string& text) {
        const std::uint64_t size = varint();
        check(size <= kMaxText && size <= in_.size());
        if (ok_) {
            text.assign(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(size));
            in_ = in_.subspan(static_cast<std::size_t>(size));
        }
    }

    template <class T>
    void operator()(std::vector<T>& items) {
        const std::uint64_t size = varint();
        check(size <= kMaxItems);
        items.resize(ok_ ? static_cast<std::size_t>(size) : 0);
        for (T& item : items) {
            T::fields(*this, item);
        }
    }

  private:
    void check(bool good) { ok_ = ok_ && good; }

    std::uint8_t byte() {
        check(!in_.empty());
        if (!ok_) {
            return 0;
        }
        const std::uint8_t value = in_.front();
        in_ = in_.subspan(1);
        return value;
    }

    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 64; shift += 7) {
            const std::uint8_t next = byte();
            value |= static_cast<std::uint64_t>(next & 0x7F) << shift;
            if ((next & 0x80) == 0) {
                return value;
            }
        }
        check(false);
        return 0;
    }

    std::uint64_t bits(int bytes) {
        std::uint64_t value = 0;
        for (int i = 0; i < bytes; ++i) {
            value |= static_cast<std::uint64_t>(byte()) << (8 * i);
        }
        return value;
    }

    std::span<const std::uint8_t> in_;
    bool ok_ = true;
};

/// Adds the fields to a state hash.
class Hasher {
  public:
    explicit Hasher(core::StateHash& hash) : hash_(hash) {}

    template <class T>
        requires std::is_integral_v<T>

    void operator()(const T& value) { hash_.add(value); }

    template <class Tag, class Rep>
    void operator()(const StrongId<Tag, Rep>& id) {
        hash_.add(id.value);
    }

    void operator()(const Life& life) { hash_.add(static_cast<std::uint64_t>(life)); }

    void operator()(const Keeping& keeping) { hash_.add(static_cast<std::uint64_t>(keeping)); }

    void operator()(const Vec3d& v) {
        for (int axis = 0; axis < 3; ++axis) {
            hash_.add(v[axis]);
        }
    }

    void operator()(const Vec3& v) {
        for (int axis = 0; axis < 3; ++axis) {
            hash_.add(v[axis]);
        }
    }

    void operator()(const std::string& text) {
        hash_.add_bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    }

    template <class T>
    void operator()(const std::vector<T>& items) {
        hash_.add(static_cast<std::uint64_t>(items.size()));
        for (const T& item : items) {
            T::fields(*this, item);
        }
    }

  private:
    core::StateHash& hash_;
};

}  // namespace zoned::rules
