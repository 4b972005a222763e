#include "tests/bench/server_process.h"

#include "tests/bench/file_text.h"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace zoned::bench {

namespace {

constexpr double kPatience_s = 60.0;

/// Nanoseconds that a thread ran: the first number of its schedstat.
double ran_s(const std::filesystem::path& task) {
    double ns = 0.0;
    std::ifstream(task / "schedstat") >> ns;
    return 1e-9 * ns;
}

}  // namespace

double number_in_json(const std::string& json, const std::string& name) {
    const std::string key = "\"" + name + "\":";
    const std::size_t at = json.find(key);
    return at == std::string::npos ? std::numeric_limits<double>::quiet_NaN()
                                   : std::strtod(json.c_str() + at + key.size(), nullptr);
}

ServerProcess::ServerProcess(const std::string& config) {
    static int count = 0;
    base_ = testing_process::scratch_folder() + "/server" + std::to_string(++count);
    std::ofstream(base_ + ".txtpb") << config;
    server_ = std::make_unique<testing_process::Child>(
        "zoned",
        std::vector<std::string>{"serve",
                                 "--config",
                                 base_ + ".txtpb",
                                 "--report",
                                 base_ + ".json",
                                 "--set",
                                 "session.state_folder=\"" + base_ + "-state\"",
                                 "--set",
                                 "network.admin=false",
                                 "--set",
                                 "network.max_load=1000"});
    if (!server_->wait_for_output("ready ", kPatience_s)) {
        throw std::runtime_error("the server does not start: " + server_->errors());
    }
    port_ = testing_process::number_after(server_->output(), "tcp=");
}

ServerProcess::~ServerProcess() {
    server_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(base_ + "-state", ignored);
}

ProcessCpu ServerProcess::cpu() const {
    const std::string folder = "/proc/" + std::to_string(server_->pid());
    ProcessCpu out;
    for (const auto& task : std::filesystem::directory_iterator(folder + "/task")) {
        out.all_s += ran_s(task.path());
    }
    // proc(5): the fields behind the name, which stands in brackets; utime is the 14th of all.
    const std::string stat = text_of_file(folder + "/stat");
    std::istringstream fields(stat.substr(stat.rfind(')') + 2));
    std::string skipped;
    for (int i = 3; i < 14; ++i) {
        fields >> skipped;
    }
    fields >> out.user_s >> out.system_s;
    const auto ticks = static_cast<double>(::sysconf(_SC_CLK_TCK));
    out.user_s /= ticks;
    out.system_s /= ticks;
    return out;
}

std::string ServerProcess::stop() {
    server_->signal(SIGTERM);
    if (const int code = server_->wait(kPatience_s); code != 0) {
        throw std::runtime_error("the server ended with " + std::to_string(code) + ": " +
                                 server_->errors());
    }
    return text_of_file(base_ + ".json");
}

}  // namespace zoned::bench
