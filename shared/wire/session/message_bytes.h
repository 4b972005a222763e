// MessageBytes: numbers, texts and tags of protobuf's wire format, written and read without the
// protobuf library.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::wire {

/// How a field lies on the wire (protobuf.dev/programming-guides/encoding).
enum class WireType : std::uint8_t {
    kVarint = 0,
    kFixed64 = 1,
    kDelimited = 2,
    kGroup = 3,
    kGroupEnd = 4,
    kFixed32 = 5,
};

struct MessageTag {
    std::uint32_t number = 0;  ///< of the field; 0: the bytes are malformed
    WireType type = WireType::kVarint;
};

/// Texts of messages hold any bytes.
[[nodiscard]] inline std::span<const std::uint8_t> bytes_of(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Appends to a buffer of the caller.
class MessageWriter {
  public:
    explicit MessageWriter(std::vector<std::uint8_t>& out) : out_(out) {}

    void tag(std::uint32_t number, WireType type);
    void varint(std::uint64_t value);
    void fixed32(std::uint32_t value);
    void fixed64(std::uint64_t value);
    void text(std::string_view bytes);

    /// Opens a part whose length stands before it; end() takes what begin() returned.
    [[nodiscard]] std::size_t begin() const { return out_.size(); }

    void end(std::size_t begun);

  private:
    std::vector<std::uint8_t>& out_;
};

/// Reads hostile bytes: after the first malformed one every answer is 0 or empty, and ok() false.
class MessageReader {
  public:
    /// Messages and groups that one field may hold in each other, as in the protobuf library.
    static constexpr int kDeepest = 100;

    explicit MessageReader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}

    [[nodiscard]] bool ok() const { return ok_; }

    /// Nothing is left to be read, or nothing can be.
    [[nodiscard]] bool done() const { return !ok_ || rest_.empty(); }

    MessageTag tag();
    std::uint64_t varint();
    std::uint32_t fixed32();
    std::uint64_t fixed64();
    std::span<const std::uint8_t> delimited();
    /// Passes over a field that the reader does not know.
    void skip(MessageTag tag, int deepest);
    void fail();

  private:
    std::uint64_t varint_of(int most_bytes);
    std::span<const std::uint8_t> take(std::size_t bytes);
    void skip_group(std::uint32_t number, int deepest);

    std::span<const std::uint8_t> rest_;
    bool ok_ = true;
};

}  // namespace zoned::wire
