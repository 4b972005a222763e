// Fuzzing of all that reads datagrams: an entry for libFuzzer, called by the unit test as well.
//
// No reader crashes or reads outside the bytes, and each accepted input encodes to the same bytes
// again. The first byte chooses the reader, the rest is its input.

#include "tests/fuzz/wire_input.h"
#include "shared/core/assert.h"

#include <cstddef>

namespace zoned::wire::fuzz {

/// The declared fields of a record that says that it has some; a `mask` of 0 where they were
/// refused. `update` holds the values.
inline DeclaredPart declared_part(RecordReader& reader,
                                  const FieldSchema& fields,
                                  DeclaredUpdate& update) {
    DeclaredPart part;
    if (reader.read_declared(&fields, update) == DeclaredFault::kNone) {
        part = {&fields, std::span(update.words).first(fields.words()), update.mask};
    }
    return part;
}

/// Reads one record and returns its new encoding; empty when it was refused or skipped.
inline Bytes reencoded_record(RecordReader& reader,
                              bool skip,
                              const FieldSchema& fields,
                              const Quantization& q) {
    Bytes out;
    const auto head = reader.next_head();
    if (!head.ok()) {
        return out;
    }
    if (head->kind == RecordKind::kRemove) {
        encode_remove(head->entity, out);
    } else if (head->kind == RecordKind::kAbsolute) {
        const auto state = reader.read_absolute(head->upright);
        if (state.ok()) {
            const Quantization level = at_lod(q, head->lod);
            const QuantizedState again = quantize(dequantize(*state, head->upright, level),
                                                  state->order,
                                                  head->upright,
                                                  state->at_rest,
                                                  state->appearance,
                                                  level);
            ZONED_ASSERT(again == *state, "an accepted state survives the way through floats");
            DeclaredUpdate update;
            const DeclaredPart part =
                head->declared ? declared_part(reader, fields, update) : DeclaredPart();
            if (head->declared == (part.mask != 0)) {
                encode_absolute(*head, *state, head->upright, q, out, part);
            }
        }
    } else if (skip) {
        (void)reader.skip_delta(head->upright);
    } else {
        const QuantizedState keyframe = keyframe_for(head->upright, at_lod(q, head->lod));
        const auto state = reader.read_delta(keyframe, head->upright);
        if (state.ok()) {
            DeclaredUpdate update;
            const DeclaredPart part =
                head->declared ? declared_part(reader, fields, update) : DeclaredPart();
            if (head->declared == (part.mask != 0)) {
                encode_delta(*head, *state, keyframe, head->upright, q, out, part);
            }
        }
    }
    return out;
}

/// Returns how many records were accepted.
inline std::size_t try_records(Input input, std::uint8_t choice) {
    const Quantization q = quantization_for(choice);
    const bool skip = (choice & 2) != 0;
    RecordReader reader(input, q);
    std::size_t accepted = 0;
    std::size_t offset = 0;
    bool comparing = true;
    while (!reader.done()) {
        const Bytes again = reencoded_record(reader, skip, fields_for(choice), q);
        // After a skipped record the offset is not known any more.
        comparing = comparing && !again.empty();
        if (comparing) {
            ZONED_ASSERT(offset + again.size() <= input.size() &&
                             same_bytes(again, input.subspan(offset, again.size())),
                         "an accepted record encodes to the same bytes");
            offset += again.size();
            ++accepted;
        }
    }
    return accepted;
}

inline std::size_t try_commands(Input input) {
    std::vector<motion::InputCommand> commands;
    if (!read_commands(input, commands).ok()) {
        ZONED_ASSERT(commands.empty(), "refused commands are not handed out");
        return 0;
    }
    Bytes again;
    write_commands(commands, again);
    ZONED_ASSERT(same_bytes(again, input), "accepted commands encode to the same bytes");
    return 1;
}

inline std::size_t try_down_head(Input input) {
    const auto parsed = read_down_head(input);
    if (!parsed.ok()) {
        return 0;
    }
    ZONED_ASSERT(parsed->records_offset <= input.size(), "records begin inside the body");
    Bytes again;
    write_down_head(parsed->head, again);
    ZONED_ASSERT(same_bytes(again, input.first(parsed->records_offset)),
                 "an accepted head encodes to the same bytes");
    return 1;
}

inline std::size_t try_fixed_headers(Input input) {
    std::size_t accepted = 0;
    if (const auto header = read_datagram_header(input); header.ok()) {
        Bytes again(kDatagramHeaderBytes);
        write_datagram_header(*header, again.data());
        ZONED_ASSERT(same_bytes(again, input.first(again.size())), "headers give back their bytes");
        ++accepted;
    }
    if (const auto down = read_down_transport(input); down.ok()) {
        Bytes again(kDownTransportBytes);
        write_transport(*down, again.data());
        ZONED_ASSERT(same_bytes(again, input.first(again.size())), "headers give back their bytes");
        ++accepted;
    }
    if (const auto up = read_up_transport(input); up.ok()) {
        Bytes again(kUpTransportBytes);
        write_transport(*up, again.data());
        ZONED_ASSERT(same_bytes(again, input.first(again.size())), "headers give back their bytes");
        ++accepted;
    }
    return accepted;
}

/// Number of accepted items; aborts when a promise is broken.
inline std::size_t try_wire(Input input) {
    if (input.empty()) {
        return 0;
    }
    const std::uint8_t choice = input[0];
    const Input rest = input.subspan(1);
    switch (choice % 4) {
        case 0:
            return try_records(rest, static_cast<std::uint8_t>(choice / 4));
        case 1:
            return try_commands(rest);
        case 2:
            return try_down_head(rest);
        default:
            return try_fixed_headers(rest);
    }
}

}  // namespace zoned::wire::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    (void)zoned::wire::fuzz::try_wire({data, size});
    return 0;
}
