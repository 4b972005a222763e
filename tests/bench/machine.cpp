#include "tests/bench/results.h"

#include <sys/utsname.h>

#include <fstream>
#include <thread>

namespace zoned::bench {

std::string machine_name() {
    std::string processor = "unknown processor";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        const std::size_t colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
            processor = line.substr(colon + 2);
            break;
        }
    }
    utsname system{};
    uname(&system);
    return processor + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores, " +
           system.sysname + " " + system.machine;
}

}  // namespace zoned::bench
