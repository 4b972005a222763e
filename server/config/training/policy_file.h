// policy_file: policies as text files, which training writes and worlds read.
#pragma once

#include "server/ai/learning/policy.h"
#include "proto/training.pb.h"
#include "shared/core/result.h"

#include <string>

namespace zoned::config {

inline constexpr std::uint32_t kPolicyVersion = 1;
/// Largest size of a policy file, bytes.
inline constexpr std::size_t kMaxPolicyBytes = 8U << 20;

proto::FlatNetwork message_of(const ai::learning::NeuralNetwork& network);

/// Fails with the reason.
core::Result<ai::learning::NeuralNetwork> network_of(const proto::FlatNetwork& message);

/// SHA-256 of all but the digest itself, hex.
std::string digest_of(const proto::PolicyFile& file);

/// Text with version and digest; `trained` describes the training for people.
std::string policy_text(const ai::learning::Policy& policy, const std::string& trained);

/// The same, with the inputs of a training file.
std::vector<ai::learning::PolicyInput> inputs_of(
    const google::protobuf::RepeatedPtrField<proto::Input>& inputs);

/// A policy that an agent can follow, from text that may come from anywhere: fails on text of
/// another schema, another version, a wrong digest, or an invalid network.
core::Result<ai::learning::Policy> parse_policy(const std::string& text);

}  // namespace zoned::config
