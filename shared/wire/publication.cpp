#include "shared/wire/publication.h"

#include "shared/wire/field_codec.h"

namespace zoned::wire {
namespace {

// Worlds of a few thousand entities and a few dozen types take the second width at most.
constexpr VarintWidths kEntityWidths{8, 12, 16, 32};
constexpr VarintWidths kTypeWidths{4, 8, 12, 16};

/// In place of a kind: absolute or delta, by the next bit, with declared fields behind the state.
constexpr std::uint32_t kWithDeclared = 3;

void write_head(BitWriter& writer,
                const RecordHead& head,
                RecordKind kind,
                bool upright,
                const DeclaredPart& declared) {
    ZONED_ASSERT(head.entity && head.lod < kLods && head.keyframe < kKeyframeNumbers,
                 "a record head outside its ranges");
    if (declared.mask != 0) {
        writer.write(kWithDeclared, 2);
        writer.write(static_cast<std::uint32_t>(kind), 1);
    } else {
        writer.write(static_cast<std::uint32_t>(kind), 2);
    }
    writer.write(head.lod, 2);
    writer.write(head.keyframe, 4);
    writer.write(head.tick_low, 8);
    write_varint(writer, head.entity.value, kEntityWidths);
    writer.write(upright ? 1 : 0, 1);
    if (kind == RecordKind::kAbsolute) {
        write_varint(writer, head.type, kTypeWidths);
    }
}

void finish_record(BitWriter& writer,
                   const DeclaredPart& declared,
                   std::vector<std::uint8_t>& out) {
    if (declared.mask != 0) {
        write_declared(writer, *declared.schema, declared.mask, declared.words);
    }
    writer.finish(out);
}

}  // namespace

Tick expand_tick(std::uint8_t tick_low, Tick packet_tick) {
    const auto age = static_cast<std::uint8_t>(static_cast<std::uint64_t>(packet_tick) - tick_low);
    return packet_tick - age;
}

void encode_absolute(const RecordHead& head,
                     const QuantizedState& state,
                     bool upright,
                     const Quantization& q,
                     std::vector<std::uint8_t>& out,
                     const DeclaredPart& declared) {
    BitWriter writer;
    write_head(writer, head, RecordKind::kAbsolute, upright, declared);
    write_fields(writer,
                 columns_of(state),
                 Columns{},
                 Coding::kAbsolute,
                 upright,
                 FieldLayout(at_lod(q, head.lod)));
    finish_record(writer, declared, out);
}

void encode_delta(const RecordHead& head,
                  const QuantizedState& state,
                  const QuantizedState& keyframe,
                  bool upright,
                  const Quantization& q,
                  std::vector<std::uint8_t>& out,
                  const DeclaredPart& declared) {
    BitWriter writer;
    write_head(writer, head, RecordKind::kDelta, upright, declared);
    write_fields(writer,
                 columns_of(state),
                 columns_of(keyframe),
                 Coding::kDelta,
                 upright,
                 FieldLayout(at_lod(q, head.lod)));
    finish_record(writer, declared, out);
}

void encode_remove(EntityId entity, std::vector<std::uint8_t>& out) {
    ZONED_ASSERT(entity, "no entity to remove");
    BitWriter writer;
    writer.write(static_cast<std::uint32_t>(RecordKind::kRemove), 2);
    write_varint(writer, entity.value, kEntityWidths);
    writer.finish(out);
}

core::Result<RecordHead> RecordReader::next_head() {
    using Head = core::Result<RecordHead>;
    ZONED_ASSERT(!state_pending_ && !declared_pending_, "the last record was not read");
    if (bits_.failed() || malformed_) {
        return Head::failure("records after a malformed one");
    }
    RecordHead head;
    const std::uint32_t kind = bits_.read(2);
    bool canonical = true;
    head.declared = kind == kWithDeclared;
    head.kind = static_cast<RecordKind>(head.declared ? bits_.read(1) : kind);
    if (head.kind != RecordKind::kRemove) {
        head.lod = static_cast<std::uint8_t>(bits_.read(2));
        head.keyframe = static_cast<std::uint8_t>(bits_.read(4));
        head.tick_low = static_cast<std::uint8_t>(bits_.read(8));
    }
    head.entity = EntityId(read_varint(bits_, kEntityWidths, canonical));
    if (head.kind != RecordKind::kRemove) {
        head.upright = bits_.read(1) != 0;
    }
    if (head.kind == RecordKind::kAbsolute) {
        head.type = static_cast<TypeIndex>(read_varint(bits_, kTypeWidths, canonical));
    }
    if (head.kind == RecordKind::kRemove) {
        bits_.align();
    }
    if (bits_.failed() || !canonical || !head.entity) {
        malformed_ = true;
        return Head::failure("malformed record head");
    }
    state_pending_ = head.kind != RecordKind::kRemove;
    head_ = head;
    return head;
}

const FieldLayout& RecordReader::layout() {
    std::optional<FieldLayout>& layout = layouts_[head_.lod];
    if (!layout) {
        layout.emplace(at_lod(quantization_, head_.lod));
    }
    return *layout;
}

void RecordReader::begin_state(RecordKind kind) {
    ZONED_ASSERT(state_pending_ && head_.kind == kind, "no state of this kind is next");
    state_pending_ = false;
}

core::Result<QuantizedState> RecordReader::read_state(const Columns& reference,
                                                      RecordKind kind,
                                                      bool upright) {
    using State = core::Result<QuantizedState>;
    begin_state(kind);
    if (upright != head_.upright) {
        malformed_ = true;
        return State::failure("record contradicts its type");
    }
    const Coding coding = kind == RecordKind::kAbsolute ? Coding::kAbsolute : Coding::kDelta;
    Columns columns;
    const bool canonical = read_fields(bits_, columns, reference, coding, upright, layout());
    if (!head_.declared) {
        bits_.align();
    }
    if (bits_.failed() || !canonical) {
        malformed_ = true;
        return State::failure("malformed record");
    }
    declared_pending_ = head_.declared;
    return state_of(columns);
}

core::Result<QuantizedState> RecordReader::read_absolute(bool upright) {
    return read_state(Columns{}, RecordKind::kAbsolute, upright);
}

core::Result<QuantizedState> RecordReader::read_delta(const QuantizedState& keyframe,
                                                      bool upright) {
    return read_state(columns_of(keyframe), RecordKind::kDelta, upright);
}

DeclaredFault RecordReader::read_declared(const FieldSchema* schema, DeclaredUpdate& update) {
    ZONED_ASSERT(declared_pending_, "no declared fields are next");
    declared_pending_ = false;
    DeclaredFault fault = DeclaredFault::kForm;
    if (schema != nullptr) {
        fault = wire::read_declared(bits_, *schema, head_.kind == RecordKind::kAbsolute, update);
    }
    bits_.align();
    if (fault == DeclaredFault::kNone && bits_.failed()) {
        fault = DeclaredFault::kForm;
    }
    malformed_ = malformed_ || fault != DeclaredFault::kNone;
    return fault;
}

DeclaredBits RecordReader::measured_declared(const FieldSchema& schema) const {
    DeclaredBits bits{};
    BitReader again = declared_at_;
    DeclaredUpdate update;
    wire::read_declared(again, schema, false, update, &bits);
    return bits;
}

core::Result<RecordHead> RecordReader::measure_next(RecordBits& bits) {
    bits = RecordBits{};
    const std::size_t begin = bits_.bit_offset();
    core::Result<RecordHead> head = next_head();
    bits[kRecordHeadPart] = static_cast<std::uint16_t>(bits_.bit_offset() - begin);
    if (!head || head->kind == RecordKind::kRemove) {
        return head;
    }
    begin_state(head->kind);
    const Coding coding = head->kind == RecordKind::kAbsolute ? Coding::kAbsolute : Coding::kDelta;
    bool known = measure_fields(bits_, coding, head->upright, layout(), bits);
    if (head->declared) {
        declared_at_ = bits_;
        known = known && skip_declared(bits_);
        bits[kDeclaredPart] =
            static_cast<std::uint16_t>(bits_.bit_offset() - declared_at_.bit_offset());
    }
    const std::size_t end = bits_.bit_offset();
    bits_.align();
    bits[kPaddingPart] = static_cast<std::uint16_t>(bits_.bit_offset() - end);
    if (bits_.failed() || !known) {
        malformed_ = true;
        return core::Result<RecordHead>::failure("malformed record");
    }
    return head;
}

core::Result<bool> RecordReader::skip_delta(bool upright) {
    using Skipped = core::Result<bool>;
    begin_state(RecordKind::kDelta);
    if (upright != head_.upright) {
        malformed_ = true;
        return Skipped::failure("record contradicts its type");
    }
    const bool known = skip_fields(bits_, Coding::kDelta, upright, layout()) &&
                       (!head_.declared || skip_declared(bits_));
    bits_.align();
    if (bits_.failed() || !known) {
        malformed_ = true;
        return Skipped::failure("malformed record");
    }
    return true;
}

}  // namespace zoned::wire
