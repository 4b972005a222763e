#include "shared/wire/declared/declared_codec.h"

namespace zoned::wire {
namespace {

std::uint32_t lowest_bits(std::uint32_t value, int bits) {
    return value & low_mask(bits);
}

}  // namespace

std::uint32_t declared_bits(const FieldSchema& schema,
                            FieldMask mask,
                            std::span<const std::uint32_t> words) {
    std::array<std::uint32_t, kMostFieldWords> copy;
    std::copy(words.begin(), words.end(), copy.begin());
    std::uint32_t length = 0;
    FieldMask chosen = mask;
    const DeclaredFault fault = code_declared(
        [&](std::uint32_t value, int bits) {
            length += static_cast<std::uint32_t>(bits);
            return lowest_bits(value, bits);
        },
        schema,
        chosen,
        std::span(copy).first(words.size()));
    ZONED_ASSERT(fault == DeclaredFault::kNone && chosen == mask, "fields hold what they can hold");
    return length;
}

void write_declared(BitWriter& writer,
                    const FieldSchema& schema,
                    FieldMask mask,
                    std::span<const std::uint32_t> words) {
    write_varint(writer, declared_bits(schema, mask, words), kDeclaredLengths);
    std::array<std::uint32_t, kMostFieldWords> copy;
    std::copy(words.begin(), words.end(), copy.begin());
    code_declared(
        [&](std::uint32_t value, int bits) {
            writer.write(value, bits);
            return lowest_bits(value, bits);
        },
        schema,
        mask,
        std::span(copy).first(words.size()));
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

FieldMask changed_from_initial(const FieldSchema& schema, std::span<const std::uint32_t> words) {
    FieldMask mask = 0;
    for (std::size_t i = 0; i < schema.fields().size(); ++i) {
        const DeclaredField& field = schema.fields()[i];
        if (!std::equal(field.initial.begin(),
                        field.initial.begin() + field.words,
                        words.begin() + field.word)) {
            mask |= FieldMask{1} << i;
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
