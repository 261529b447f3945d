// Scene files: what they say arrives, and what is wrong in them is refused in one line that names
// file, key and value.
#include "src/io/scene_file.h"

#include <gtest/gtest.h>

#include "src/base/check.h"
#include "tests/src/scratch_folder.h"

namespace zygoma {
namespace {

const std::string kMotion = R"("motion": {"keys": [{"time_s": 0}]})";

TEST(SceneFileTest, WhatIsLeftOutHasItsUsualValue) {
  const ScratchFolder folder;
  const Scene scene = read_scene(folder.write("s.json", "{" + kMotion + "}"));
  const Scene usual;
  EXPECT_EQ(scene.head.num_surface_vertices, usual.head.num_surface_vertices);
  EXPECT_EQ(scene.tissue.lattice.layers, tri_layer());
  EXPECT_EQ(scene.tissue.effects, usual.tissue.effects);
  EXPECT_EQ(scene.settle.solver, Solver::kImplicit);
  EXPECT_EQ(scene.settle.relative_residual, usual.settle.relative_residual);
  EXPECT_EQ(scene.motion.frames_per_s, 30.0);
  EXPECT_EQ(scene.motion.keys.size(), 1U);
}

TEST(SceneFileTest, EverythingItSaysArrives) {
  const ScratchFolder folder;
  const Scene scene = read_scene(folder.write("s.json", R"({
    "about": "all keys",
    "head": {"surface_vertices": 500, "skin_levels": 1, "albedo_size_px": 256,
             "identity": {"face_width": 1.1, "skin_tone": [0.5, 0.25, 1], "texture_seed": 7}},
    "tissue": {"topology": "centroids", "stiffness": "constant", "law": "literal",
               "layers": [{"name": "skin", "bottom_share": 0.5, "modulus_kpa": 20,
                           "stiff_ratio": 2, "bulk_ratio": 3, "alpha_mn_per_mm": 4},
                          {"name": "flesh"}],
               "epidermis_modulus_kpa": 99, "epidermis_thickness_mm": 0.2,
               "epidermis_stiff_ratio": 3, "epidermis_alpha_mn_per_mm": 33,
               "region_stiffness": {"upper_lip": 2, "lower_lid": 0.5},
               "density_kg_per_mm3": 2e-6, "smallest_fill": 0.4},
    "muscles": {"hold_kpa_per_mm": 10, "slip_hold_ratio": 5, "slip_elsewhere": 0.25,
                "slip_reach_mm": 12, "rim_hold_ratio": 2},
    "effects": {},
    "solver": {"kind": "explicit", "relative_residual": 1e-3, "max_iterations": 7,
               "still_mm": 0.05},
    "motion": {"frames_per_s": 25, "duration_s": 3,
               "keys": [{"time_s": 0},
                        {"time_s": 1.5, "jaw": 0.5,
                         "contractions": {"zygomaticus_major": 0.75,
                                          "depressor_anguli_oris_L": 0.125}}]}
  })"));
  EXPECT_EQ(scene.head.num_surface_vertices, 500);
  EXPECT_EQ(scene.head.skin_levels, 1);
  EXPECT_EQ(scene.head.albedo_size_px, 256);
  EXPECT_EQ(scene.identity.face_width, 1.1);
  EXPECT_EQ(scene.identity.skin_tone, Eigen::Vector3f(0.5F, 0.25F, 1.0F));
  EXPECT_EQ(scene.identity.texture_seed, 7U);
  const LatticeOptions& lattice = scene.tissue.lattice;
  EXPECT_EQ(lattice.topology, Topology::kCentroids);
  EXPECT_EQ(lattice.stiffness, Stiffness::kConstant);
  EXPECT_EQ(lattice.law, SpringLaw::kLiteral);
  ASSERT_EQ(lattice.layers.size(), 2U);
  EXPECT_EQ(lattice.layers[0], (TissueLayer{"skin", 0.5, 20.0, 2.0, 3.0, 4.0}));
  EXPECT_EQ(lattice.layers[1].name, "flesh");
  EXPECT_EQ(lattice.epidermis_modulus_kpa, 99.0);
  EXPECT_EQ(lattice.epidermis_thickness_mm, 0.2);
  EXPECT_EQ(lattice.epidermis_stiff_ratio, 3.0);
  EXPECT_EQ(lattice.epidermis_alpha_mn_per_mm, 33.0);
  EXPECT_EQ(lattice.region_stiffness, (std::array<double, 5>{1.0, 2.0, 1.0, 1.0, 0.5}));
  EXPECT_EQ(lattice.density_kg_per_mm3, 2e-6);
  EXPECT_EQ(lattice.smallest_fill, 0.4);
  EXPECT_EQ(scene.tissue.muscles.hold_kpa_per_mm, 10.0);
  EXPECT_EQ(scene.tissue.muscles.slip_hold_ratio, 5.0);
  EXPECT_EQ(scene.tissue.muscles.slip_elsewhere, 0.25);
  EXPECT_EQ(scene.tissue.muscles.slip_reach_mm, 12.0);
  EXPECT_EQ(scene.tissue.muscles.rim_hold_ratio, 2.0);
  EXPECT_TRUE(scene.tissue.effects.empty());
  EXPECT_EQ(scene.settle.solver, Solver::kExplicit);
  EXPECT_EQ(scene.settle.relative_residual, 1e-3);
  EXPECT_EQ(scene.settle.max_iterations, 7);
  EXPECT_EQ(scene.settle.still_mm, 0.05);
  EXPECT_EQ(scene.motion.frames_per_s, 25.0);
  EXPECT_EQ(scene.motion.duration_s, 3.0);
  ASSERT_EQ(scene.motion.keys.size(), 2U);
  const MotionKey& key = scene.motion.keys[1];
  EXPECT_EQ(key.time_s, 1.5);
  EXPECT_EQ(key.jaw, 0.5);
  EXPECT_EQ(key.contraction,
            (std::map<std::string, double>{{"zygomaticus_major_L", 0.75},
                                           {"zygomaticus_major_R", 0.75},
                                           {"depressor_anguli_oris_L", 0.125}}));
}

TEST(SceneFileTest, EffectsAndWordsForLayers) {
  const ScratchFolder folder;
  const Scene scene = read_scene(folder.write(
      "s.json",
      R"({"tissue": {"layers": "bi"}, "effects": {"volume": {"factor": 2}}, )" + kMotion + "}"));
  EXPECT_EQ(scene.tissue.lattice.layers, bi_layer());
  EXPECT_EQ(scene.tissue.effects, (std::vector<EffectChoice>{{"volume", {{"factor", 2.0}}}}));
}

TEST(SceneFileTest, EffectsLeftToTheProgram) {
  const ScratchFolder folder;
  const auto scene_with = [&](const std::string& effects) {
    return read_scene(folder.write("s.json", R"({"effects": )" + effects + ", " + kMotion + "}"));
  };
  EXPECT_EQ(scene_with(R"({"volume": {}})").settle.choose_mm, 0.0);
  EXPECT_EQ(scene_with(R"("auto")").settle.choose_mm, SettleOptions::kUsualChooseMm);
  EXPECT_EQ(scene_with(R"("auto")").tissue.effects, usual_effects());
  const Scene exact = scene_with(R"({"auto": {"tolerance_mm": 0.02}})");
  EXPECT_EQ(exact.settle.choose_mm, 0.02);
  EXPECT_EQ(exact.tissue.effects, usual_effects());
  const Scene some = scene_with(R"({"auto": {}, "volume": {}, "viscosity": {"ratio": 2}})");
  EXPECT_EQ(some.settle.choose_mm, SettleOptions::kUsualChooseMm);
  EXPECT_EQ(some.tissue.effects,
            (std::vector<EffectChoice>{{"viscosity", {{"ratio", 2.0}}}, {"volume", {}}}));
}

struct BadScene {
  const char* text;  // of the file; one that begins with a quote gets braces and a motion
  std::vector<std::string> words;
};

std::string pose(const std::string& contractions) {
  return R"({"motion": {"keys": [{"time_s": 0, "contractions": )" + contractions + "}]}}";
}

const std::vector<BadScene> kBadScenes{
    // not JSON
    {"", {"not valid JSON at byte 1"}},
    {"{\"head\": }", {"not valid JSON at byte 10"}},
    {"{\"head\": {}", {"not valid JSON at byte 12"}},
    {"{\"muscles\": {\"slip_elsewhere\": NaN}}", {"not valid JSON at byte 32"}},
    {"{\"muscles\": {\"slip_elsewhere\": Infinity}}", {"not valid JSON at byte 32"}},
    {"{\"head\": \"\xff\"}", {"not valid JSON at byte 11"}},
    {R"({"solver": {"still_mm": 1e999}})", {"too large", "'still_mm'"}},
    // not of its form
    {"[]", {"a list of 0", "expected an object"}},
    {"7", {"'7'", "expected an object"}},
    {"{}", {"motion", "null", "what the face does"}},
    {R"("haed": {})", {"'haed' is unknown", "head, tissue, muscles, effects, solver, motion"}},
    {R"("about": 3)", {"about: '3'", "a text"}},
    {R"("head": 3)", {"head: '3'", "an object"}},
    {R"("head": {}, "head": {})", {"'head' is there twice"}},
    {R"("tissue": {"law": "smooth", "law": "literal"})", {"'law' is there twice"}},
    // head
    {R"("head": {"vertices": 400})", {"head: 'vertices' is unknown", "surface_vertices"}},
    {R"("head": {"surface_vertices": 1e9})", {"surface_vertices is 1e+09", "300 to 4000"}},
    {R"("head": {"surface_vertices": 1e10})", {"head.surface_vertices: '10000000000.0'", "whole"}},
    {R"("head": {"surface_vertices": 300.5})", {"head.surface_vertices: '300.5'", "whole"}},
    {R"("head": {"skin_levels": -1})", {"skin_levels is -1", "0 to 3"}},
    {R"("head": {"identity": {"face_width": 3}})", {"face_width is 3", "0.88 to 1.14"}},
    {R"("head": {"identity": {"skin_tone": [1, 1]}})", {"identity.skin_tone: a list of 2"}},
    {R"("head": {"identity": {"skin_tone": [1, 1, "x"]}})", {"skin_tone[2]: '\"x\"'", "a number"}},
    {R"("head": {"identity": {"hair_tone": [1, 1, 2]}})", {"hair_tone is 2", "0 to 1"}},
    {R"("head": {"identity": {"texture_seed": -1}})", {"texture_seed: '-1'", "whole number"}},
    // tissue
    {R"("tissue": {"topology": "voxels"})", {"topology: '\"voxels\"'", "prisms, centroids"}},
    {R"("tissue": {"stiffness": 3})", {"tissue.stiffness: '3'", "calibrated, constant"}},
    {R"("tissue": {"law": null})", {"tissue.law: 'null'", "smooth, literal"}},
    {R"("tissue": {"layers": "four"})", {"tissue.layers: '\"four\"'", "tri, bi"}},
    {R"("tissue": {"layers": [{"name": "a"}]})", {"layers: a list of 1", "2 to 16 layers"}},
    {R"("tissue": {"layers": [{}, {}]})", {"layers[0].name: 'null'", "a name"}},
    {R"("tissue": {"layers": [{"name": "a", "bottom_share": 0.5, "modulus_kpa": -3},
                              {"name": "b"}]})",
     {"a: modulus_kpa is -3", "0.001 to 1e+05"}},
    {R"("tissue": {"layers": [{"name": "a"}, {"name": "b"}]})", {"b: bottom_share is 1", "grow"}},
    {R"("tissue": {"layers": [{"name": "a", "colour": 1}, {"name": "b"}]})",
     {"layers[0]: 'colour' is unknown"}},
    {R"("tissue": {"epidermis_modulus_kpa": -1})", {"epidermis_modulus_kpa is -1"}},
    {R"("tissue": {"epidermis_modulus_kpa": "soft"})", {"modulus_kpa: '\"soft\"'", "a number"}},
    {R"("tissue": {"region_stiffness": {"cheek": 1}})", {"'cheek' is unknown", "upper_lip"}},
    {R"("tissue": {"region_stiffness": {"face": 0}})", {"region_stiffness is 0", "0.001 to 100"}},
    {R"("tissue": {"density_kg_per_mm3": 1e-12})", {"density_kg_per_mm3 is 1e-12", "1e-09"}},
    // muscles
    {R"("muscles": {"hold_kpa_per_mm": 0})", {"hold_kpa_per_mm is 0", "0.001 to 10000"}},
    {R"("muscles": {"slip_elsewhere": true})", {"muscles.slip_elsewhere: 'true'", "a number"}},
    {R"("muscles": {"strength": 1})", {"muscles: 'strength' is unknown", "hold_kpa_per_mm"}},
    // effects
    {R"("effects": [])", {"effects: a list of 0", "an object"}},
    {R"("effects": "all")", {"effects: '\"all\"'", "\"auto\" or an object"}},
    {R"("effects": {"auto": {"tolerance_mm": 0}})", {"tolerance_mm is 0", "above 0"}},
    {R"("effects": {"auto": {"tolerance_mm": 11}})", {"tolerance_mm is 11", "at most 10"}},
    {R"("effects": {"auto": {"calm": 1}})", {"effects.auto: 'calm' is unknown", "tolerance_mm"}},
    {R"("effects": "auto", "solver": {"kind": "explicit"})", {"auto goes with", "equilibrium"}},
    {R"("effects": {"gravty": {}})", {"effects: 'gravty' is unknown", "volume"}},
    {R"("effects": {"volume": 1})", {"effects.volume: '1'", "an object of its parameters"}},
    {R"("effects": {"volume": {"colour": 1}})", {"effects.volume: 'colour'", "factor"}},
    {R"("effects": {"volume": {"factor": "much"}})", {"effects.volume.factor", "a number"}},
    {R"("effects": {"volume": {"factor": -1}})", {"volume: factor is -1", "0 to 100"}},
    // solver
    {R"("solver": {"kind": "magic"})", {"solver.kind: '\"magic\"'", "equilibrium, explicit"}},
    {R"("solver": {"relative_residual": 0})", {"relative_residual is 0", "(0, 1]"}},
    {R"("solver": {"max_iterations": 0})", {"solver.max_iterations is 0", "1 to 1e+06"}},
    {R"("solver": {"still_mm": -0.1})", {"solver.still_mm is -0.1", "0 to 10"}},
    // motion
    {R"({"motion": {}})", {"motion.keys: 'null'", "at least one pose"}},
    {R"({"motion": {"keys": []}})", {"motion.keys: a list of 0", "at least one pose"}},
    {R"({"motion": {"keys": [{}]}})", {"motion.keys[0].time_s: 'null'", "the time"}},
    {R"({"motion": {"keys": [{"time_s": -1}]}})", {"motion.keys[0].time_s is -1", "0 to 3600"}},
    {R"({"motion": {"keys": [{"time_s": 1}, {"time_s": 1}]}})", {"keys[1].time_s is 1", "later"}},
    {R"({"motion": {"keys": [{"time_s": 2}, {"time_s": 1}]}})", {"keys[1].time_s is 1", "later"}},
    {R"({"motion": {"keys": [{"time_s": 0, "jaw": 2}]}})", {"keys[0].jaw is 2", "0 to 1"}},
    {R"({"motion": {"keys": [{"time_s": 0, "pose": 2}]}})", {"keys[0].pose: '2', expected a text"}},
    {R"({"motion": {"frames_per_s": 0, "keys": [{"time_s": 0}]}})", {"frames_per_s is 0"}},
    {R"({"motion": {"duration_s": 3600, "frames_per_s": 1000, "keys": [{"time_s": 0}]}})",
     {"3600000 frames", "below 100000"}},
};

TEST(SceneFileTest, RefusesWhatIsWrongInOneLine) {
  const ScratchFolder folder;
  const auto expect_refused = [&](const std::string& text, const std::vector<std::string>& words) {
    SCOPED_TRACE(text);
    const std::string file = folder.write("bad.json", text);
    const std::string message = message_of<InputError>([&] { read_scene(file); });
    EXPECT_TRUE(message.starts_with(file + ":")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_LT(message.size(), file.size() + 1200);
    for (const std::string& word : words) {
      EXPECT_NE(message.find(word), std::string::npos) << "no " << word << " in: " << message;
    }
  };
  for (const BadScene& bad : kBadScenes) {
    const std::string text = bad.text;
    const bool is_part = text.starts_with('"');
    expect_refused(is_part ? "{" + text + ", " + kMotion + "}" : text, bad.words);
  }
  expect_refused(pose("[]"), {"keys[0].contractions: a list of 0", "an object"});
  expect_refused(pose(R"({"zygomaticus": 1})"), {"'zygomaticus' is unknown", "zygomaticus_major"});
  expect_refused(pose(R"({"zygomaticus_major_L": 1.5})"),
                 {"keys[0].contractions.zygomaticus_major_L is 1.5", "0 to 1"});
  expect_refused(pose(R"({"zygomaticus_major_L": "x"})"), {"zygomaticus_major_L: '\"x\"'"});
  expect_refused(pose(R"({"zygomaticus_major_L": 1, "zygomaticus_major": 1})"),
                 {"zygomaticus_major_L is there twice"});
  expect_refused(pose("{\"" + std::string(5000, 'm') + "\": 1}"), {"mmm...' is unknown"});
  expect_refused(std::string(100000, '['), {"not valid JSON"});
}

TEST(SceneFileTest, MissingFile) {
  const std::string message = message_of<InputError>([] { read_scene("/nowhere/scene.json"); });
  EXPECT_EQ(message.find("/nowhere/scene.json: No such file"), 0U) << message;
}

}  // namespace
}  // namespace zygoma
