// The commands of the zoned program, each a function from its arguments to an exit code.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace zoned::app {

/// Exit codes of all programs.
enum ExitCode : int {
    kGood = 0,
    kFailed = 1,       ///< a verdict or comparison failed
    kUsage = 2,        ///< bad usage or config
    kEnvironment = 3,  ///< port in use, no such file, no permission, ...
};

struct ServeArguments {
    std::string config;
    std::vector<std::string> sets;
    double seconds = 0.0;  ///< 0: until a signal
    std::string report;
    bool restart = false;              ///< a server that dies is started again
    std::vector<std::string> cluster;  ///< URLs of NATS servers; none: the realm is this process
};

struct NewArguments {
    std::string folder;        ///< not there yet, or empty
    std::string name;          ///< of the game; empty: the folder's
    std::string game = "tag";  ///< or "capture_the_flag"
    bool lua = false;          ///< rules in a script, in place of C++
    bool test = false;         ///< goes on as the game's test.sh
};

struct ExplainArguments {
    std::string config;
    std::vector<std::string> sets;
    unsigned viewers = 0;
    unsigned bots = 0;  ///< players who walk about
    unsigned ticks = 90;
    bool analyze = false;      ///< goes on for `seconds`, and compares what was expected
    double seconds = 5.0;      ///< of the world's time
    bool json = false;         ///< of the analysis
    std::string diagram;       ///< name of a brain: its diagram in place of the plan
    std::string svg;           ///< file for it; empty: as text for Graphviz on standard output
    std::uint32_t entity = 0;  ///< explain the actions of this agent, in place of the plan
};

struct TicketArguments {
    std::string key;  ///< private key file
    std::string out;  ///< ticket file; empty: standard output, one line of base64
    std::string account;
    std::string name;
    std::string team;
    std::string world;  ///< empty: any
    std::vector<std::string> rights;
    double hours = 24.0;
};

struct ReplayArguments {
    std::string file;  ///< or a folder with the pieces of a ring
    unsigned threads = 1;
    std::int64_t from = 0;   ///< first tick that is compared, or copied to `out`
    std::int64_t to = 0;     ///< last tick; 0: all
    std::string out;         ///< a recording of these ticks; nothing is simulated
    bool info = false;       ///< says what the file holds; nothing is simulated
    bool serve = false;      ///< shows it in the viewer
    std::uint16_t port = 0;  ///< of the viewer; 0: any free one
};

struct BakeArguments {
    std::string file;
    std::string out;     ///< empty: the file's name and ".baked"
    bool check = false;  ///< nothing is written
    // Options of an OBJ file.
    std::optional<float> scale;  ///< m per unit of the file
    std::optional<float> weld;   ///< m
    // Options of a PNG image.
    std::optional<float> height;     ///< m from black to white
    std::optional<float> spacing;    ///< m between samples
    std::optional<float> offset;     ///< m, height of black
    std::optional<float> thickness;  ///< m
    float error_budget_m = 0.005F;   ///< as physics.error_budget_m of a config
};

struct TrainArguments {
    std::string file;
    bool resume = false;   ///< goes on from the checkpoint
    bool restart = false;  ///< begins anew although there is one
    unsigned threads = 1;
};

/// What `zoned ctl` asks of a running server.
struct CtlArguments {
    std::string admin;        ///< HOST:PORT; empty: as `state` says
    std::string token_file;   ///< empty: the one in `state`
    std::string certificate;  ///< of a server that speaks TLS; empty: the one in `state`
    std::string state = "state";
    bool json = false;
    std::string command;
    std::string account;
    std::string name;
    std::string reason;
    std::string text;  ///< to say, PATH=VALUE to set, a log level, a type to spawn, on or off
    std::string area;  ///< of the log; empty: all
    std::string file;  ///< name of a recording; empty: by the time
    std::vector<double> position_m;
    double yaw_deg = 0.0;
    std::uint32_t client = 0;
    std::uint32_t entity = 0;
    double hours = 0.0;
    double grace_s = 30.0;
    double every_s = 1.0;
    unsigned count = 0;
};

/// Where the store lies, and what is done with it.
struct StoreArguments {
    std::string state = "state";
    std::string file;     ///< empty: store.db in `state`
    std::string url;      ///< of a PostgreSQL database, instead of a file
    std::string backup;   ///< file that is made, or restored
    std::string account;  ///< whose events; empty: all
    unsigned count = 20;
};

/// Questions and orders of operators to a cluster.
struct ClusterArguments {
    std::vector<std::string> urls;
    std::string realm = "zoned";
    std::string world;
    double grace_s = 30.0;
    bool json = false;
};

int serve(const ServeArguments& arguments);
int new_game(NewArguments arguments);
int check(const std::string& config, const std::vector<std::string>& sets);
int explain(const ExplainArguments& arguments);
int explain_diagram(const ExplainArguments& arguments);
int bake(const BakeArguments& arguments);
int keygen(const std::string& base);
int ticket(const TicketArguments& arguments);
int replay(const ReplayArguments& arguments);
int train(const TrainArguments& arguments);
int ctl(const CtlArguments& arguments);
int backup(const StoreArguments& arguments);
int restore(const StoreArguments& arguments);
int cluster_status(const ClusterArguments& arguments);
int cluster_drain(const ClusterArguments& arguments);
int store_check(const StoreArguments& arguments);
int store_events(const StoreArguments& arguments);

/// Adds `zoned ctl` with all its commands; `run` becomes what the arguments ask for.
void add_ctl(CLI::App& app, CtlArguments& arguments, std::function<int()>& run);

/// Adds `zoned backup`, `zoned restore` and `zoned store` with its commands.
void add_store(CLI::App& app, StoreArguments& arguments, std::function<int()>& run);

/// Adds `zoned cluster` with its commands.
void add_cluster(CLI::App& app, ClusterArguments& arguments, std::function<int()>& run);

/// Parses and dispatches; never throws.
int run_command_line(int argc, char** argv);

}  // namespace zoned::app
