#include "tests/bench/cpu_clock.h"
#include "tests/bench/public_data.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite_replication.h"
#include "shared/core/rng.h"
#include "shared/wire/snapshot/orientation_coder.h"
#include "shared/wire/snapshot/snapshot_codec.h"

#include <algorithm>
#include <map>
#include <set>

namespace zoned::bench {

namespace {

constexpr int kBits = 9;
constexpr int kRoundTrip = 6;  ///< frames: snapshot i is coded against i - 6
constexpr double kFramesPerSecond = 60.0;

/// The data leaves out one of x, y, z, w; samples leave out one of w, x, y, z. The same bits in
/// another order.
void set_orientation(wire::snapshot::BodySample& sample, int left_out, const std::int32_t* abc) {
    std::array<std::int32_t, 4> wxyz{};
    for (int i = 0; i < 4; ++i) {
        wxyz[static_cast<std::size_t>((i + 1) % 4)] = i == left_out ? -1 : *abc++;
    }
    std::size_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        if (wxyz[i] < 0) {
            sample.left_out = static_cast<std::uint8_t>(i);
        } else {
            sample.orientation[next++] = static_cast<std::int16_t>(wxyz[i]);
        }
    }
}

std::vector<wire::snapshot::Snapshot> snapshots_of(const std::vector<CubeRecord>& records) {
    std::vector<wire::snapshot::Snapshot> all(records.size() / kCubes,
                                              wire::snapshot::Snapshot(kCubes));
    for (std::size_t i = 0; i < records.size(); ++i) {
        const CubeRecord& r = records[i];
        wire::snapshot::BodySample& sample = all[i / kCubes][i % kCubes];
        set_orientation(sample, r[0], &r[1]);
        sample.position = {r[4], r[5], r[6]};
        sample.mark = static_cast<std::uint8_t>(r[7]);
    }
    return all;
}

wire::snapshot::SnapshotFormat format_of_cubes() {
    wire::snapshot::SnapshotFormat format;
    format.bodies = kCubes;
    format.orientation_bits = kBits;
    format.minimum = {-16383, -16383, 0};
    format.maximum = {16383, 16383, 8191};
    return format;
}

struct Coded {
    double bytes = 0.0;  ///< per packet
    std::vector<double> time_us;
    int wrong = 0;
    int refused = 0;
    int decoded = 0;

    [[nodiscard]] double kbit_per_s() const { return bytes * kFramesPerSecond * 8.0 / 1000.0; }
};

/// The task as published: each snapshot against the one six before it, all of which arrive.
Coded code_in_order(const std::vector<wire::snapshot::Snapshot>& all) {
    wire::snapshot::SnapshotEncoder encoder(format_of_cubes());
    wire::snapshot::SnapshotDecoder decoder(format_of_cubes());
    Coded coded;
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = kRoundTrip; i < all.size(); ++i) {
        const auto known = static_cast<wire::snapshot::FrameNumber>(i - kRoundTrip + 1);
        if (i < 2 * kRoundTrip) {
            encoder.share(known, all[i - kRoundTrip]);
            decoder.share(known, all[i - kRoundTrip]);
        } else {
            encoder.acknowledge(known);
        }
        bytes.clear();
        const auto number = static_cast<wire::snapshot::FrameNumber>(i + 1);
        const std::int64_t begin_ns = thread_cpu_ns();
        encoder.encode(number, all[i], bytes);
        const auto decoded = decoder.decode(number, bytes);
        coded.time_us.push_back(1e-3 * static_cast<double>(thread_cpu_ns() - begin_ns));
        coded.wrong += decoded && **decoded == all[i] ? 0 : 1;
        coded.bytes += static_cast<double>(bytes.size());
    }
    coded.bytes /= static_cast<double>(coded.time_us.size());
    return coded;
}

/// One direction of a network: 5 % are lost, the others take 1 to 5 frames, three in the mean.
template <class Message>
class Lossy {
  public:
    explicit Lossy(std::uint64_t stream) : rng_(901, stream) {}

    void send(double now, Message message) {
        const bool lost = rng_.below(20) == 0;
        const double delay = 3.0 + static_cast<double>(rng_.range(-2.0F, 2.0F));
        if (!lost) {
            under_way_.emplace(now + delay, std::move(message));
        }
    }

    /// The packets that have come by `now`, in the order in which they came.
    std::vector<Message> receive(double now) {
        std::vector<Message> due;
        while (!under_way_.empty() && under_way_.begin()->first <= now) {
            due.push_back(std::move(under_way_.begin()->second));
            under_way_.erase(under_way_.begin());
        }
        return due;
    }

  private:
    core::Rng rng_;
    std::multimap<double, Message> under_way_;
};

struct Packet {
    wire::snapshot::FrameNumber number = 0;
    std::vector<std::uint8_t> bytes;
};

/// Over a network that loses 5 % in each direction and delays by two frames more or less. Each
/// frame the client acknowledges the newest snapshot received and names which of the 32 before it
/// arrived.
Coded code_over_network(const std::vector<wire::snapshot::Snapshot>& all) {
    wire::snapshot::SnapshotEncoder encoder(format_of_cubes());
    wire::snapshot::SnapshotDecoder decoder(format_of_cubes());
    encoder.share(1, all[0]);
    decoder.share(1, all[0]);
    Lossy<Packet> down(1);
    Lossy<std::vector<wire::snapshot::FrameNumber>> up(2);
    std::set<wire::snapshot::FrameNumber> received;
    Coded coded;
    for (std::size_t i = kRoundTrip; i < all.size(); ++i) {
        const auto now = static_cast<double>(i);
        for (const auto& numbers : up.receive(now)) {
            for (const wire::snapshot::FrameNumber number : numbers) {
                encoder.acknowledge(number);
            }
        }
        Packet packet{static_cast<wire::snapshot::FrameNumber>(i + 1), {}};
        encoder.encode(packet.number, all[i], packet.bytes);
        coded.bytes += static_cast<double>(packet.bytes.size());
        down.send(now, std::move(packet));
        for (const Packet& p : down.receive(now)) {
            const auto decoded = decoder.decode(p.number, p.bytes);
            if (!decoded) {
                ++coded.refused;
                continue;
            }
            ++coded.decoded;
            coded.wrong += **decoded == all[p.number - 1] ? 0 : 1;
            received.insert(p.number);
        }
        while (!received.empty() && *received.begin() + 32 < *received.rbegin()) {
            received.erase(received.begin());
        }
        up.send(now, {received.begin(), received.end()});
    }
    coded.bytes /= static_cast<double>(all.size() - kRoundTrip);
    return coded;
}

void run_cubes(Session& session, const std::string& which) {
    const std::string scene = "cubes901_" + which;
    if (!session.wants_scene(scene) || !session.wants_method("default", "")) {
        return;
    }
    session.progress("replication " + scene);
    std::string why;
    const std::vector<wire::snapshot::Snapshot> all =
        snapshots_of(read_cubes(which, session.quick ? 300 : 2837, why));
    if (all.empty()) {
        session.note(why);
        return;
    }
    Coded coded;
    std::vector<std::vector<double>> runs;
    for (int repeat = 0; repeat < (session.quick ? 1 : session.repeats); ++repeat) {
        coded = code_in_order(all);
        runs.push_back(coded.time_us);
    }
    const std::vector<double> time_us = median_of_rows(runs);
    const Coded network = code_over_network(all);
    Row row;
    row.suite = "replication";
    row.scene = scene;
    row.time_us_p50 = quantile(time_us, 0.5);
    row.time_us_p99 = quantile(time_us, 0.99);
    row.error = coded.wrong + network.wrong;
    row.error_unit = "snapshots";
    row.metric("payload_kbit_per_s", coded.kbit_per_s());
    row.metric("payload_loss5_kbit_per_s", network.kbit_per_s());
    row.metric("refused_loss5_packets", network.refused);
    row.metric("time_us_mean", mean(time_us));
    session.add({row});
}

void run_captured(Session& session) {
    if (!session.wants_scene("orientations") || !session.wants_method("default", "")) {
        return;
    }
    session.progress("replication orientations");
    std::string why;
    std::vector<OrientationPair> pairs = read_orientations(why);
    if (pairs.empty()) {
        session.note(why);
        return;
    }
    if (session.quick) {
        pairs.resize(std::min<std::size_t>(pairs.size(), 10'000));
    }
    const auto sample_of = [](const std::array<std::int32_t, 4>& values) {
        wire::snapshot::BodySample sample;
        set_orientation(sample, values[0], &values[1]);
        return sample;
    };
    std::vector<std::uint8_t> bytes;
    const std::int64_t begin_ns = thread_cpu_ns();
    {
        wire::entropy::RangeEncoder coder(bytes);
        wire::snapshot::OrientationCoder orientations(kBits);
        for (const OrientationPair& pair : pairs) {
            orientations.encode(coder, sample_of(pair.before), sample_of(pair.now));
        }
        coder.finish();
    }
    wire::entropy::RangeDecoder coder(bytes);
    wire::snapshot::OrientationCoder orientations(kBits);
    int wrong = 0;
    for (const OrientationPair& pair : pairs) {
        wire::snapshot::BodySample sample;
        orientations.decode(coder, sample_of(pair.before), sample);
        wrong += sample == sample_of(pair.now) ? 0 : 1;
    }
    const double time_us =
        1e-3 * static_cast<double>(thread_cpu_ns() - begin_ns) / static_cast<double>(pairs.size());
    Row row;
    row.suite = "replication";
    row.scene = "orientations";
    row.time_us_p50 = time_us;
    row.time_us_p99 = time_us;
    row.error = wrong + (coder.complete() ? 0 : 1);
    row.error_unit = "orientations";
    row.metric("bits_per_orientation",
               8.0 * static_cast<double>(bytes.size()) / static_cast<double>(pairs.size()));
    session.add({row});
}

}  // namespace

void run_snapshots(Session& session) {
    run_cubes(session, "A");
    run_cubes(session, "B");
    run_captured(session);
}

}  // namespace zoned::bench
