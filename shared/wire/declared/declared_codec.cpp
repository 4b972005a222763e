#include "shared/wire/declared/declared_codec.h"

namespace zoned::wire {
namespace {

std::uint32_t lowest_bits(std::uint32_t value, int bits) {
    return value & low_mask(bits);
}

}  // namespace

void write_declared(BitWriter& writer,
                    const FieldSchema& schema,
                    std::uint32_t mask,
                    std::span<const std::uint32_t> words) {
    std::array<std::uint32_t, kMostFieldWords> copy;
    std::copy(words.begin(), words.end(), copy.begin());
    const std::span<std::uint32_t> own = std::span(copy).first(words.size());
    std::uint32_t length = 0;
    std::uint32_t chosen = mask;
    DeclaredFault fault = code_declared(
        [&](std::uint32_t value, int bits) {
            length += static_cast<std::uint32_t>(bits);
            return lowest_bits(value, bits);
        },
        schema,
        chosen,
        own);
    ZONED_ASSERT(fault == DeclaredFault::kNone && chosen == mask, "fields hold what they can hold");
    write_varint(writer, length, kDeclaredLengths);
    fault = code_declared(
        [&](std::uint32_t value, int bits) {
            writer.write(value, bits);
            return lowest_bits(value, bits);
        },
        schema,
        chosen,
        own);
}

DeclaredFault read_declared(BitReader& reader,
                            const FieldSchema& schema,
                            bool whole,
                            DeclaredUpdate& update,
                            DeclaredBits* bits) {
    bool canonical = true;
    const std::uint32_t length = read_varint(reader, kDeclaredLengths, canonical);
    const std::size_t end = reader.bit_offset() + length;
    update.whole = whole;
    update.mask = 0;
    bool cut = false;
    const DeclaredFault fault = code_declared(
        [&](std::uint32_t /*value*/, int width) {
            cut = cut || reader.bit_offset() + static_cast<std::size_t>(width) > end;
            return cut ? 0U : reader.read(width);
        },
        schema,
        update.mask,
        update.words,
        bits);
    if (cut || reader.failed()) {
        return DeclaredFault::kCut;
    }
    if (fault != DeclaredFault::kNone) {
        return fault;
    }
    if (!canonical || reader.bit_offset() != end || (whole && !is_whole(schema, update))) {
        return DeclaredFault::kForm;
    }
    return DeclaredFault::kNone;
}

bool skip_declared(BitReader& reader) {
    bool canonical = true;
    std::uint32_t left = read_varint(reader, kDeclaredLengths, canonical);
    while (left > 0) {
        const std::uint32_t bits = std::min<std::uint32_t>(left, 32);
        reader.read(static_cast<int>(bits));
        left -= bits;
    }
    return canonical;
}

std::uint32_t changed_from_initial(const FieldSchema& schema,
                                   std::span<const std::uint32_t> words) {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < schema.fields().size(); ++i) {
        const DeclaredField& field = schema.fields()[i];
        if (!std::equal(field.initial.begin(),
                        field.initial.begin() + field.words,
                        words.begin() + field.word)) {
            mask |= 1U << i;
        }
    }
    return mask;
}

void apply_declared(const FieldSchema& schema,
                    const DeclaredUpdate& update,
                    std::vector<std::uint32_t>& words) {
    if (update.whole || words.size() != schema.words()) {
        words.assign(schema.initial().begin(), schema.initial().end());
    }
    for (std::size_t i = 0; i < schema.fields().size(); ++i) {
        if ((update.mask >> i & 1U) != 0) {
            const DeclaredField& field = schema.fields()[i];
            std::copy_n(update.words.begin() + field.word, field.words, words.begin() + field.word);
        }
    }
}

}  // namespace zoned::wire
