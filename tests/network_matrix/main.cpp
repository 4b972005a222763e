// zoned-network-matrix: bots on every kind of bad network, cell by cell; exit code 1 where a
// verdict fails.
#include "tests/network_matrix/cell.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <exception>

namespace {

/// One line; true when the cell is good.
bool run_one(const zoned::network_matrix::Cell& cell,
             const zoned::network_matrix::CellSettings& settings) {
    const zoned::network_matrix::CellResult result =
        zoned::network_matrix::run_cell(cell, settings);
    const zoned::measure::RunReport& r = result.report;
    const bool good = r.consistent && result.healed && r.audit.samples > 0;
    std::printf(
        "%-52s %-4s %8llu samples, p99 %.3f m, stale %4.1f %%, %5llu events, exact after "
        "%.2f s, %5.0f B/s\n",
        zoned::network_matrix::name_of(cell).c_str(),
        good ? "good" : "BAD",
        static_cast<unsigned long long>(r.audit.samples),
        r.audit.predicted_m.percentile(0.99),
        100.0 * static_cast<double>(r.audit.samples_stale) /
            static_cast<double>(r.audit.samples > 0 ? r.audit.samples : 1),
        static_cast<unsigned long long>(r.events_delivered),
        result.healed_s,
        r.down_bytes_per_s.percentile(0.5));
    for (const std::string& reason : r.reasons) {
        std::printf("    %s\n", reason.c_str());
    }
    std::fflush(stdout);
    return good;
}

}  // namespace

int main(int argc, char** argv) {
    zoned::network_matrix::CellSettings settings;
    settings.config = ZONED_SOURCE_DIR "/config/minimal.txtpb";
    bool quick = false;
    std::string only;
    CLI::App app(
        "zoned-network-matrix: verdicts on every combination of what a network does wrong");
    app.add_flag("--quick", quick, "18 cells in which every pair of settings occurs, not all 144");
    app.add_option("--only", only, "Cells whose name contains this");
    app.add_option("--config", settings.config, "Another world");
    app.add_option("--set", settings.sets, "path.to.field=value in the config (repeatable)");
    app.add_option("--bots", settings.bots, "Bots in each cell");
    app.add_option("--seconds", settings.seconds, "Length of each run");
    app.add_option("--seed", settings.seed, "Seed of behaviours and networks");
    CLI11_PARSE(app, argc, argv);
    int bad = 0;
    int run = 0;
    try {
        for (const zoned::network_matrix::Cell& cell :
             quick ? zoned::network_matrix::pairwise_cells() : zoned::network_matrix::all_cells()) {
            if (zoned::network_matrix::name_of(cell).find(only) != std::string::npos) {
                ++run;
                bad += run_one(cell, settings) ? 0 : 1;
            }
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "zoned-network-matrix: %s\n", error.what());
        return 3;
    }
    std::printf("%d cells, %d bad\n", run, bad);
    return bad == 0 && run > 0 ? 0 : 1;
}
