"""The register of scenes; it imports nothing, so that their names cost nothing."""

SCENE_GROUP = "mot_sim.scenes"  # of the entry points by which other packages register theirs
# The knobs that every scene has, with their defaults. The four after the look are fields of
# `WeatherAxes`, the last three of `Surroundings`.
COMMON_KNOBS: dict[str, int | float | str | bool] = {
    "profile": "rrc",
    "weather": "noon",
    "camera_look": "kitti",
    "fog": 0.0,
    "rain": 0.0,
    "sun_elevation": 0.0,
    "exposure": 0.0,
    "houses": 1.0,
    "trees": 1.0,
    "furniture": 1.0,
}
# The name of a scene: the module and the function that makes it; its arguments are its knobs.
SCENES: dict[str, str] = {
    "crossing": "scenes.crossing:crossing",
    "gauntlet": "scenes.gauntlet:gauntlet",
    "highway": "scenes.highway:highway",
    "intersection": "scenes.intersection:intersection",
    "intersection_blind_corner": "scenes.intersection_blind_corner:intersection_blind_corner",
    "intersection_double_parked": "scenes.intersection_double_parked:intersection_double_parked",
    "intersection_give_way": "scenes.intersection_give_way:intersection_give_way",
    "intersection_left_turn": "scenes.intersection_left_turn:intersection_left_turn",
    "intersection_queues": "scenes.intersection_queues:intersection_queues",
    "look_alikes": "scenes.look_alikes:look_alikes",
    "merge": "scenes.merge:merge",
    "roundabout": "scenes.roundabout:roundabout",
    "stop_and_go": "scenes.stop_and_go:stop_and_go",
    "street": "scenes.street:street",
    "t_junction": "scenes.t_junction:t_junction",
    "town": "scenes.town:town",
}
