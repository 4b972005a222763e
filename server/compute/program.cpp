// How a device comes by its programs: from the cache, or built from source and stored there.
#include "server/compute/device_impl.h"

namespace zoned::compute {

namespace {

/// Options on which equal results on host and device depend. FP_CONTRACT is off in the source.
constexpr const char* kExactOptions = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt";

std::string build_log(const OpenClApi& cl, cl_program program, cl_device_id device) {
    std::size_t size = 0;
    cl.clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
    std::string log(size, '\0');
    if (size > 0) {
        cl.clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
        log.resize(log.find('\0') == std::string::npos ? size : log.find('\0'));
    }
    return log.empty() ? "the compiler says nothing" : log;
}

}  // namespace

core::Result<cl_program> Device::Impl::program(std::string_view file, const std::string& options) {
    const std::pair<std::string, std::string> name(file, options);
    const auto known = programs.find(name);
    if (known != programs.end()) {
        return known->second;
    }
    const auto failed = broken.find(name);
    if (failed != broken.end()) {
        return core::Result<cl_program>::failure(failed->second);
    }
    const auto source = kernels ? expand_kernel(file, kernels) : kernel_source(file);
    if (!source) {
        return core::Result<cl_program>::failure(source.error());
    }
    std::string all_options = kExactOptions;
    if (!options.empty()) {
        all_options += ' ';
        all_options += options;
    }
    const ProgramKey key{info.platform + "/" + info.name, info.driver, all_options, *source};
    cl_program loaded = load(key);
    if (loaded != nullptr) {
        ++counts.loaded;
        programs.emplace(name, loaded);
        return loaded;
    }
    const auto built = build(file, *source, all_options);
    if (built) {
        ++counts.built;
        programs.emplace(name, *built);
        store(key, *built);
    } else {
        broken.emplace(name, built.error());
    }
    return built;
}

core::Result<cl_program> Device::Impl::build(std::string_view file,
                                             const std::string& source,
                                             const std::string& options) const {
    using Built = core::Result<cl_program>;
    const char* text = source.c_str();
    const std::size_t size = source.size();
    const cl_device_id id = device();
    cl_int code = CL_SUCCESS;
    cl_program made = cl->clCreateProgramWithSource(context, 1, &text, &size, &code);
    if (code == CL_SUCCESS) {
        code = cl->clBuildProgram(made, 1, &id, options.c_str(), nullptr, nullptr);
    }
    if (code == CL_SUCCESS) {
        return made;
    }
    std::string why = std::string(file) + " does not build for " + to_text(info) + " with \"" +
                      options + "\": " + opencl_error(code);
    if (made != nullptr) {
        why += "\n" + name_places(build_log(*cl, made, id), source);
        cl->clReleaseProgram(made);
    }
    return Built::failure(std::move(why));
}

cl_program Device::Impl::load(const ProgramKey& key) const {
    const auto binary = cache.load(key);
    if (!binary || (testing != nullptr && testing->refuse_binaries)) {
        return nullptr;
    }
    const unsigned char* bytes = binary->data();
    const std::size_t size = binary->size();
    const cl_device_id id = device();
    cl_int code = CL_SUCCESS;
    cl_program made = cl->clCreateProgramWithBinary(context, 1, &id, &size, &bytes, nullptr, &code);
    if (code == CL_SUCCESS) {
        code = cl->clBuildProgram(made, 1, &id, key.options.c_str(), nullptr, nullptr);
    }
    if (code != CL_SUCCESS && made != nullptr) {
        cl->clReleaseProgram(made);  // a binary that the driver refuses is built anew
        return nullptr;
    }
    return code == CL_SUCCESS ? made : nullptr;
}

void Device::Impl::store(const ProgramKey& key, cl_program built) {
    std::size_t size = 0;
    if (cl->clGetProgramInfo(built, CL_PROGRAM_BINARY_SIZES, sizeof(size), &size, nullptr) !=
            CL_SUCCESS ||
        size == 0) {
        return;
    }
    std::vector<std::uint8_t> binary(size);
    unsigned char* bytes = binary.data();
    if (cl->clGetProgramInfo(built, CL_PROGRAM_BINARIES, sizeof(bytes), &bytes, nullptr) ==
            CL_SUCCESS &&
        cache.store(key, binary)) {
        ++counts.stored;
    }
}

}  // namespace zoned::compute
