// coded-stream SEED PACKETS: a stream of coded packets and what is in them, for decoders that are
// written from the page. Things walk, fly, tumble, jump, rest and go; packets and acknowledgements
// are lost or late; levels of detail, zones and ages of publications vary.
#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/record/record_codec.h"

#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

namespace zoned::wire::testing {
namespace {

constexpr float kTickS = 1.0F / 30.0F;

struct Mover {
    motion::KinematicState state;
    bool rests = false;
    motion::PredictorOrder order = motion::PredictorOrder::kStatic;  // as which it is told
    bool known = false;
};

class MoverWorld {
  public:
    explicit MoverWorld(std::uint64_t seed) : rng(seed) {}

    std::vector<record::CodedRecord> records(Tick tick, const record::RecordFormat& format) {
        std::vector<record::CodedRecord> out;
        for (std::uint32_t i = 1; i <= 24; ++i) {
            Mover& mover = movers_[i - 1];
            move(mover);
            if (rng.below(4) == 0 || (mover.rests && mover.known && rng.below(6) != 0)) {
                continue;
            }
            record::CodedRecord& record = out.emplace_back();
            record.entity = EntityId(7 * i);
            record.remove = mover.known && rng.below(50) == 0;
            mover.known = !record.remove;
            if (!record.remove) {
                tell(mover, i, tick, format, record);
            }
        }
        return out;
    }

    core::Rng rng;

  private:
    void move(Mover& mover) {
        if (rng.below(40) == 0) {
            mover.rests = rng.below(3) == 0;
            const auto kinds = static_cast<std::uint32_t>(motion::kPredictorOrders);
            mover.order = static_cast<motion::PredictorOrder>(rng.below(2) * rng.below(kinds));
            mover.state.floor = mover.state.position.y() - 0.1F * static_cast<float>(rng.below(40));
        }
        motion::KinematicState& s = mover.state;
        if (!mover.known || rng.below(60) == 0) {
            s.position = random_vector(rng, 400.0F);
            s.orientation = random_rotation(rng);
        }
        if (rng.below(10) == 0) {
            s.velocity = random_vector(rng, 4.0F);
            s.angular_velocity = random_vector(rng, 3.0F);
            s.acceleration = random_vector(rng, 9.0F);
            s.turn = random_vector(rng, 2.0F);
        }
        if (!mover.rests) {
            s.position += kTickS * s.velocity;
            const Vec3 half = 0.5F * kTickS * s.angular_velocity;
            s.orientation = (Quat(1.0F, half.x(), half.y(), half.z()) * s.orientation).normalized();
        }
    }

    void tell(const Mover& mover,
              std::uint32_t i,
              Tick tick,
              const record::RecordFormat& format,
              record::CodedRecord& record) {
        record.upright = i % 3 == 0;
        record.type = static_cast<TypeIndex>(i % 5);
        const bool other = rng.below(15) == 0;
        record.lod = static_cast<std::uint8_t>(other ? rng.below(kLods) : i % 4 == 0 ? 1 : 0);
        record.tick = tick - static_cast<Tick>(rng.below(8) == 0 ? rng.below(4) : 0);
        record.state = quantize(mover.state,
                                mover.order,
                                record.upright,
                                mover.rests,
                                static_cast<std::uint16_t>(rng.below(30) == 0 ? rng.below(9) : 0),
                                format.levels[record.lod].quantization);
    }

    std::array<Mover, 24> movers_;
};

void print(const record::RecordFrame& frame, const std::vector<std::uint8_t>& code, bool lost) {
    std::printf("packet %u %lld %u %d ",
                frame.number,
                static_cast<long long>(frame.tick),
                static_cast<unsigned>(frame.zone.value),
                lost ? 1 : 0);
    for (const std::uint8_t byte : code) {
        std::printf("%02x", byte);
    }
    std::printf("\n");
    for (const record::CodedRecord& r : frame.records) {
        std::printf("%u", r.entity.value);
        if (!r.remove) {
            const QuantizedState& s = r.state;
            std::printf(" %d %d %lld %d %d",
                        r.type,
                        r.upright ? 1 : 0,
                        static_cast<long long>(r.tick),
                        r.lod,
                        columns_of(s)[0]);
            for (const auto* vector : {&s.position,
                                       &s.velocity,
                                       &s.acceleration,
                                       &s.turn,
                                       &s.orientation,
                                       &s.angular_velocity}) {
                std::printf(" %d %d %d", (*vector)[0], (*vector)[1], (*vector)[2]);
            }
            std::printf(" %d %d %d", s.orientation_largest, s.appearance, s.floor);
        }
        std::printf("\n");
    }
}

void run(std::uint64_t seed, Tick ticks) {
    Quantization quantization;
    quantization.lod_shift = {{{0, 0}, {1, 1}, {2, 1}, {4, 3}}};
    const record::RecordFormat format(quantization, kTickS);
    record::RecordEncoder encoder(format);
    MoverWorld world(seed);
    std::multimap<Tick, entropy::PacketNumber> acknowledged;
    entropy::PacketNumber number = 0;
    for (Tick tick = 100; tick < 100 + ticks; ++tick) {
        for (auto it = acknowledged.begin(); it != acknowledged.end() && it->first <= tick;) {
            encoder.acknowledge(it->second);
            it = acknowledged.erase(it);
        }
        const ZoneId zone(static_cast<std::uint16_t>(1 + tick / 120 % 2));
        const std::vector<record::CodedRecord> all = world.records(tick, format);
        const std::size_t half = world.rng.below(6) == 0 ? all.size() / 2 : all.size();
        for (const auto& part : {std::span(all).first(half), std::span(all).subspan(half)}) {
            if (part.empty()) {
                continue;
            }
            std::vector<std::uint8_t> code;
            const auto frame = encoder.encode(++number, tick, zone, part, code);
            encoder.sent(frame);
            const bool lost = world.rng.below(12) == 0;
            print(*frame, code, lost);
            if (!lost && world.rng.below(10) != 0) {
                acknowledged.emplace(tick + 2 + static_cast<Tick>(world.rng.below(4)), number);
            }
        }
    }
}

}  // namespace
}  // namespace zoned::wire::testing

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: coded-stream SEED TICKS\n");
        return 2;
    }
    zoned::wire::testing::run(std::strtoull(argv[1], nullptr, 10), std::atoi(argv[2]));
    return 0;
}
