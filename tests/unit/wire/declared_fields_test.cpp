#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/declared/declared_codec.h"
#include "shared/wire/publication.h"
#include "shared/wire/record/record_codec.h"
#include "shared/wire/record/record_traffic.h"

#include <gtest/gtest.h>

#include <deque>
#include <limits>

namespace zoned::wire {
namespace {

using testing::change_field;
using testing::health_alone;
using testing::most_fields;
using testing::random_quantized;
using testing::sample_fields;
using Bytes = std::vector<std::uint8_t>;

constexpr bool kUpright = true;

DeclaredField number(std::string name, double minimum, double quantum, std::uint32_t most) {
    DeclaredField field;
    field.name = std::move(name);
    field.minimum = minimum;
    field.quantum = quantum;
    field.most = most;
    return field;
}

RecordHead head_of(std::uint32_t entity) {
    RecordHead head;
    head.entity = EntityId(entity);
    head.type = 3;
    return head;
}

TEST(FieldSchema, RefusesFieldsThatNoConfigMayHave) {
    const auto refused = [](DeclaredField field) {
        std::vector<DeclaredField> fields{std::move(field)};
        return !FieldSchema::make(std::move(fields)).ok();
    };
    EXPECT_FALSE(refused(number("health", 0.0, 1.0, 100)));
    EXPECT_TRUE(refused(number("", 0.0, 1.0, 100)));
    EXPECT_TRUE(refused(number(std::string(33, 'x'), 0.0, 1.0, 100)));
    EXPECT_TRUE(refused(number("a\x80", 0.0, 1.0, 100)));
    EXPECT_TRUE(refused(number("health", 0.0, 0.0, 100)));
    EXPECT_TRUE(refused(number("health", 0.0, 1.0, 0)));
    EXPECT_TRUE(refused(number("health", 0.0, 1.0, 1U << 24U)));
    EXPECT_TRUE(refused(number("health", std::numeric_limits<double>::infinity(), 1.0, 100)));
    DeclaredField beyond = number("health", 0.0, 1.0, 100);
    beyond.initial[0] = 101;
    EXPECT_TRUE(refused(beyond));
    DeclaredField choice;
    choice.name = "mood";
    choice.kind = DeclaredKind::kEnum;
    choice.values = {"calm"};
    EXPECT_TRUE(refused(choice));
    choice.values = {"calm", "calm"};
    EXPECT_TRUE(refused(choice));
    DeclaredField text;
    text.name = "title";
    text.kind = DeclaredKind::kText;
    text.initial[0] = 1U | 0x80U << 8U;  // one byte, which is no character
    EXPECT_TRUE(refused(text));
    EXPECT_FALSE(FieldSchema::make({}).ok());
    EXPECT_FALSE(FieldSchema::make({number("a", 0, 1, 1), number("a", 0, 1, 1)}).ok());
    std::vector<DeclaredField> many;
    for (int i = 0; i < 65; ++i) {
        many.push_back(number("n" + std::to_string(i), 0.0, 1.0, 1));
    }
    EXPECT_FALSE(FieldSchema::make(many).ok());
    many.pop_back();
    EXPECT_TRUE(FieldSchema::make(many).ok());
    for (int i = 0; i < 10; ++i) {
        many[static_cast<std::size_t>(i)].kind = DeclaredKind::kText;
    }
    EXPECT_FALSE(FieldSchema::make(many).ok()) << "10 texts and 54 others have 134 words";
}

TEST(DeclaredFields, HoldWhatTheirKindHolds) {
    const auto schema = sample_fields();
    std::vector<std::uint32_t> words(schema->initial().begin(), schema->initial().end());
    const auto put = [&](std::size_t i, FieldValue value) {
        const DeclaredField& field = schema->fields()[i];
        return put_value(field, value, words_of(field, std::span(words)));
    };
    const auto text = [&](std::size_t i) {
        const DeclaredField& field = schema->fields()[i];
        return text_of(field, words_of<const std::uint32_t>(field, words));
    };
    EXPECT_EQ(text(0), "100");
    EXPECT_EQ(put(0, 41.5), FieldOutcome::kDone);
    EXPECT_EQ(text(0), "42");
    EXPECT_EQ(put(0, 1e30), FieldOutcome::kClamped);
    EXPECT_EQ(text(0), "100");
    EXPECT_EQ(put(0, -0.51), FieldOutcome::kClamped);
    EXPECT_EQ(text(0), "0");
    EXPECT_EQ(put(0, std::numeric_limits<double>::quiet_NaN()), FieldOutcome::kRefused);
    EXPECT_EQ(put(0, true), FieldOutcome::kRefused);
    EXPECT_EQ(put(1, -9.99998), FieldOutcome::kDone);
    EXPECT_EQ(text(1), "-9.99998");
    EXPECT_EQ(put(2, std::string_view("angry")), FieldOutcome::kDone);
    EXPECT_EQ(put(2, std::string_view("bored")), FieldOutcome::kRefused);
    EXPECT_EQ(text(2), "angry");
    EXPECT_EQ(put(3, true), FieldOutcome::kDone);
    EXPECT_EQ(text(3), "true");
    EXPECT_EQ(put(3, 1.0), FieldOutcome::kRefused);
    const std::string longest(31, 'x');
    EXPECT_EQ(put(4, std::string_view(longest)), FieldOutcome::kDone);
    EXPECT_EQ(put(4, std::string_view(longest + "x")), FieldOutcome::kRefused);
    EXPECT_EQ(put(4, std::string_view("a\xC3")), FieldOutcome::kRefused);
    EXPECT_EQ(text(4), longest);
    EXPECT_EQ(put(4, std::string_view("\xC3\xA9")), FieldOutcome::kDone);
    EXPECT_EQ(text(4), "\xC3\xA9");
}

TEST(DeclaredFields, ComeBackFromSharedRecordsBitForBit) {
    const Quantization q;
    core::Rng rng(5);
    for (const auto& schema : {sample_fields(), health_alone(), most_fields()}) {
        std::vector<std::uint32_t> truth(schema->initial().begin(), schema->initial().end());
        std::vector<std::uint32_t> known;
        for (int i = 0; i < 2000; ++i) {
            FieldMask mask = 0;
            for (std::size_t f = 0; f < schema->fields().size(); ++f) {
                if (rng.below(3) == 0) {
                    change_field(rng, schema->fields()[f], truth);
                    mask |= FieldMask{1} << f;
                }
            }
            const bool absolute = i == 0 || rng.below(4) == 0;
            const DeclaredPart part{
                schema.get(), truth, absolute ? changed_from_initial(*schema, truth) : mask};
            const QuantizedState state = random_quantized(rng, kUpright, q);
            const QuantizedState keyframe = random_quantized(rng, kUpright, q);
            Bytes bytes;
            if (absolute) {
                encode_absolute(head_of(7), state, kUpright, q, bytes, part);
            } else {
                encode_delta(head_of(7), state, keyframe, kUpright, q, bytes, part);
            }
            encode_remove(EntityId(9), bytes);  // the records behind it are found

            RecordReader measured(bytes, q);
            RecordBits bits;
            ASSERT_TRUE(measured.measure_next(bits).ok());
            EXPECT_EQ(bits[kDeclaredPart] > 0, part.mask != 0);

            RecordReader reader(bytes, q);
            const auto head = reader.next_head();
            ASSERT_TRUE(head.ok());
            ASSERT_EQ(head->declared, part.mask != 0);
            if (!absolute && rng.below(4) == 0) {
                ASSERT_TRUE(reader.skip_delta(kUpright).ok());
                known = truth;
            } else {
                const auto read = absolute ? reader.read_absolute(kUpright)
                                           : reader.read_delta(keyframe, kUpright);
                ASSERT_TRUE(read.ok());
                EXPECT_EQ(*read, state);
                DeclaredUpdate update;
                update.whole = absolute;
                if (head->declared) {
                    ASSERT_EQ(reader.read_declared(schema.get(), update), DeclaredFault::kNone);
                }
                apply_declared(*schema, update, known);
            }
            ASSERT_EQ(known, truth) << i;
            ASSERT_TRUE(reader.next_head().ok());
            EXPECT_TRUE(reader.done());
        }
    }
}

/// A record whose part for declared fields is written bit by bit.
DeclaredFault fault_of(const FieldSchema& schema,
                       bool absolute,
                       std::initializer_list<std::pair<std::uint32_t, int>> part,
                       std::uint32_t length) {
    BitWriter writer;
    write_varint(writer, length, kDeclaredLengths);
    for (const auto& [value, bits] : part) {
        writer.write(value, bits);
    }
    Bytes bytes;
    writer.finish(bytes);
    BitReader reader(bytes);
    DeclaredUpdate update;
    return read_declared(reader, schema, absolute, update);
}

TEST(DeclaredFields, AreRefusedForWhatIsWrongWithThem) {
    const auto sample = sample_fields();
    const auto health = health_alone();
    // One field: nothing but its 7 bits.
    EXPECT_EQ(fault_of(*health, false, {{100, 7}}, 7), DeclaredFault::kNone);
    EXPECT_EQ(fault_of(*health, false, {{101, 7}}, 7), DeclaredFault::kRange);
    EXPECT_EQ(fault_of(*health, false, {{3, 2}}, 2), DeclaredFault::kCut);
    EXPECT_EQ(fault_of(*health, false, {{100, 7}, {0, 1}}, 8), DeclaredFault::kForm);
    EXPECT_EQ(fault_of(*health, true, {{100, 7}}, 7), DeclaredFault::kForm);  // its initial value
    // Five fields: one by its number in 3 bits, or several by a mask.
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {2, 3}, {2, 2}}, 6), DeclaredFault::kNone);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {2, 3}, {3, 2}}, 6), DeclaredFault::kRange);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {5, 3}, {0, 2}}, 6), DeclaredFault::kForm);
    EXPECT_EQ(fault_of(*sample, false, {{1, 1}, {4, 5}, {2, 2}}, 8), DeclaredFault::kForm);
    EXPECT_EQ(fault_of(*sample, false, {{1, 1}, {12, 5}, {2, 2}, {1, 1}}, 9), DeclaredFault::kNone);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {1, 3}, {1'000'000, 20}}, 24),
              DeclaredFault::kNone);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {1, 3}, {1'000'001, 20}}, 24),
              DeclaredFault::kRange);
    // A text: its length, its bytes.
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {4, 3}, {2, 5}, {0xA9C3, 16}}, 25),
              DeclaredFault::kNone);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {4, 3}, {2, 5}, {0xC3C3, 16}}, 25),
              DeclaredFault::kText);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {4, 3}, {1, 5}, {7, 8}}, 17), DeclaredFault::kText);
    EXPECT_EQ(fault_of(*sample, false, {{0, 1}, {4, 3}, {3, 5}, {0xA9C3, 16}}, 25),
              DeclaredFault::kCut);
}

TEST(DeclaredFields, OfATypeWithoutAnyAreRefused) {
    const Quantization q;
    core::Rng rng(1);
    const auto schema = health_alone();
    const std::vector<std::uint32_t> words{7};
    Bytes bytes;
    encode_absolute(head_of(7),
                    random_quantized(rng, kUpright, q),
                    kUpright,
                    q,
                    bytes,
                    {schema.get(), words, 1});
    RecordReader reader(bytes, q);
    ASSERT_TRUE(reader.next_head().ok());
    ASSERT_TRUE(reader.read_absolute(kUpright).ok());
    DeclaredUpdate update;
    EXPECT_EQ(reader.read_declared(nullptr, update), DeclaredFault::kForm);
    EXPECT_TRUE(reader.done());
}

/// Declared fields of some entities, published from tick to tick.
struct Publications final : record::DeclaredSource {
    struct Entity {
        std::vector<std::uint32_t> words;
        std::vector<Tick> changed;
    };

    explicit Publications(const FieldSchema& schema) : fields(schema) {
        for (Entity& entity : entities) {
            entity.words.assign(schema.initial().begin(), schema.initial().end());
            entity.changed.assign(schema.fields().size(), 0);
        }
    }

    void change(core::Rng& rng, Tick tick, std::uint32_t one_in) {
        for (Entity& entity : entities) {
            for (std::size_t f = 0; f < fields.fields().size(); ++f) {
                if (rng.below(one_in) == 0) {
                    change_field(rng, fields.fields()[f], entity.words);
                    entity.changed[f] = tick;
                }
            }
        }
    }

    [[nodiscard]] record::DeclaredValues declared_of(EntityId entity) const override {
        const Entity& found = entities[entity.value - 1];
        return {found.words, found.changed};
    }

    const FieldSchema& fields;
    std::array<Entity, 12> entities;
};

void code_with_losses(const std::shared_ptr<const FieldSchema>& schema) {
    const record::RecordFormat format(Quantization{}, 1.0F / 30.0F, {nullptr, schema});
    record::RecordEncoder encoder(format);
    record::RecordDecoder decoder(format);
    Publications world(*schema);
    core::Rng rng(3);
    std::array<std::vector<std::uint32_t>, 12> known;
    std::deque<entropy::PacketNumber> acks;
    TrafficTable sent;
    TrafficTable came;
    int decoded = 0;
    for (entropy::PacketNumber number = 1; number <= 1500; ++number) {
        const auto tick = static_cast<Tick>(number);
        world.change(rng, tick, 12);
        std::vector<record::CodedRecord> records;
        for (std::uint32_t i = 0; i < 12; ++i) {
            if (rng.below(3) != 0) {
                record::CodedRecord r;
                r.entity = EntityId(i + 1);
                r.type = i % 2 == 0 ? 1 : 0;  // type 0 has no fields
                r.upright = true;
                r.tick = tick;
                r.state = random_quantized(rng, true, format.levels[0].quantization);
                records.push_back(r);
            }
        }
        Bytes bytes;
        auto frame = encoder.encode(number, tick, ZoneId(1), records, bytes, true, &world);
        record::add_traffic(
            sent, *frame, bytes.size(), format.fields, [](const auto&) { return TrafficReason(); });
        encoder.sent(frame);
        while (acks.size() > 3) {
            encoder.acknowledge(acks.front());
            acks.pop_front();
        }
        if (rng.below(5) == 0) {
            continue;  // lost
        }
        const auto back = decoder.decode(number, tick, ZoneId(1), bytes, true);
        ASSERT_TRUE(back) << back.error();
        record::add_traffic(
            came, **back, bytes.size(), format.fields, [](const auto&) { return TrafficReason(); });
        acks.push_back(number);
        ++decoded;
        for (const record::CodedRecord& r : (*back)->records) {
            if (r.type == 0) {
                EXPECT_EQ(r.declared, 0U);
                continue;
            }
            const std::uint32_t i = r.entity.value - 1;
            ASSERT_GT(r.declared, 0U);
            apply_declared(*schema, (*back)->declared[r.declared - 1], known[i]);
            ASSERT_EQ(known[i], world.entities[i].words) << number;
        }
    }
    EXPECT_GT(decoded, 1000);
    ASSERT_EQ(came.declared().size(), schema->fields().size());
    ASSERT_EQ(sent.declared().size(), schema->fields().size());
    for (const TrafficTable::DeclaredSum& sum : came.declared()) {
        EXPECT_GT(sum.bits, 0U);
    }
}

TEST(DeclaredFields, ComeBackFromCodedRecordsWhateverIsLost) {
    code_with_losses(sample_fields());
    code_with_losses(most_fields());
}

TEST(DeclaredFields, DamagedInCodedPacketsAreRefusedOrInRange) {
    const auto schema = sample_fields();
    const record::RecordFormat format(Quantization{}, 1.0F / 30.0F, {schema});
    Publications world(*schema);
    core::Rng rng(8);
    world.change(rng, 1, 1);
    std::vector<record::CodedRecord> records(1);
    records[0].entity = EntityId(1);
    records[0].upright = true;
    records[0].tick = 1;
    records[0].state = random_quantized(rng, true, format.levels[0].quantization);
    Bytes bytes;
    record::RecordEncoder encoder(format);
    (void)encoder.encode(1, 1, ZoneId(1), records, bytes, false, &world);
    int refused = 0;
    int by_fields = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        Bytes damaged = bytes;
        damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        record::RecordDecoder decoder(format);
        const auto frame = decoder.decode(1, 1, ZoneId(1), damaged);
        if (!frame) {
            ++refused;
            by_fields += frame.error() == "malformed records" ? 0 : 1;
            continue;
        }
        for (const DeclaredUpdate& update : (*frame)->declared) {
            for (std::size_t f = 0; f < schema->fields().size(); ++f) {
                const DeclaredField& field = schema->fields()[f];
                if ((update.mask >> f & 1U) != 0 && field.kind != DeclaredKind::kText) {
                    EXPECT_LE(update.words[field.word], field.most);
                }
            }
        }
    }
    EXPECT_GT(refused, 10);
    EXPECT_GT(by_fields, 0);
}

/// The cost of a change of one value from 0 to 100, in both ways of coding, beside the same values
/// in the 16 bits of `appearance`.
TEST(DeclaredFields, CostNoMoreThanABuiltInField) {
    for (const bool coded : {false, true}) {
        const auto schema = health_alone();
        const Quantization q;
        const record::RecordFormat format(q, 1.0F / 30.0F, {schema});
        record::RecordEncoder encoder(format);
        Publications world(*schema);
        core::Rng rng(4);
        TrafficTable traffic;
        QuantizedState keyframe;
        Tick keyframe_tick = 0;
        QuantizedState state = random_quantized(rng, true, q);
        for (Tick tick = 1; tick <= 3000; ++tick) {
            if (tick % 5 == 0) {
                world.entities[0].words[0] = rng.below(101);
                world.entities[0].changed[0] = tick;
                state.appearance = static_cast<std::uint16_t>(world.entities[0].words[0]);
            }
            Bytes bytes;
            if (coded) {
                record::CodedRecord r;
                r.entity = EntityId(1);
                r.upright = true;
                r.tick = tick;
                r.state = state;
                const auto frame = encoder.encode(static_cast<entropy::PacketNumber>(tick),
                                                  tick,
                                                  ZoneId(1),
                                                  {&r, 1},
                                                  bytes,
                                                  true,
                                                  &world);
                record::add_traffic(traffic, *frame, bytes.size(), format.fields, [](const auto&) {
                    return TrafficReason();
                });
                encoder.sent(frame);
                if (tick > 3) {
                    encoder.acknowledge(static_cast<entropy::PacketNumber>(tick - 3));
                }
                continue;
            }
            if (tick % 8 == 1) {
                keyframe = state;
                keyframe_tick = tick;
            }
            const bool changed = world.entities[0].changed[0] > keyframe_tick;
            const DeclaredPart part{schema.get(), world.entities[0].words, changed ? 1U : 0U};
            encode_delta(head_of(1), state, keyframe, true, q, bytes, part);
            RecordReader reader(bytes, q);
            RecordBits bits;
            ASSERT_TRUE(reader.measure_next(bits).ok());
            traffic.add_record(0, TrafficReason::kUpdate, bits);
        }
        const auto built_in = static_cast<double>(traffic.bits_of_part(kFields.size() - 1));
        const auto declared = static_cast<double>(traffic.bits_of_part(kDeclaredPart));
        ASSERT_STREQ(kFields.back().name, "appearance");
        EXPECT_GT(declared, 0.0);
        EXPECT_LE(declared, 1.1 * built_in) << (coded ? "coded" : "shared");
        RecordProperty(coded ? "coded_share" : "shared_share", std::to_string(declared / built_in));
        std::printf("%s: declared %.0f bits, appearance %.0f bits\n",
                    coded ? "coded" : "shared",
                    declared,
                    built_in);
    }
}

}  // namespace
}  // namespace zoned::wire
