"""What a person would write with pymeshlab for the scripts of the corpus.

Each function runs on a document and returns, in order, what its filters measured.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pymeshlab import Color, PercentageValue, PureValue

Measures = list[dict[str, Any]]


def clean_scan(ms: Any) -> Measures:
    ms.meshing_remove_duplicate_vertices()
    ms.meshing_remove_duplicate_faces()
    ms.meshing_remove_null_faces()
    ms.meshing_repair_non_manifold_edges(method="Remove Faces")
    ms.meshing_remove_connected_component_by_face_number(mincomponentsize=25, removeunref=True)
    ms.meshing_remove_unreferenced_vertices()
    return []


def clean_scan_2014(ms: Any) -> Measures:
    ms.meshing_remove_duplicate_vertices()
    ms.meshing_repair_non_manifold_edges(method="Remove Faces")
    ms.meshing_remove_null_faces()
    ms.meshing_remove_unreferenced_vertices()
    return []


def clean_by_diameter(ms: Any) -> Measures:
    ms.meshing_remove_connected_component_by_diameter(mincomponentdiag=PureValue(0.5))
    ms.meshing_merge_close_vertices(threshold=PureValue(0.0001))
    ms.meshing_repair_non_manifold_edges()
    ms.meshing_repair_non_manifold_vertices(vertdispratio=0)
    ms.meshing_remove_t_vertices(method="Edge Flip", threshold=40, repeat=True)
    ms.meshing_remove_folded_faces()
    return []


def print_preparation(ms: Any) -> Measures:
    ms.meshing_merge_close_vertices()
    ms.meshing_remove_duplicate_faces()
    ms.meshing_remove_null_faces()
    ms.meshing_remove_connected_component_by_face_number()
    ms.meshing_repair_non_manifold_edges()
    closed = ms.meshing_close_holes(maxholesize=60, selfintersection=True)
    ms.meshing_re_orient_faces_coherently()
    ms.compute_matrix_from_scaling_or_normalization(
        axisx=25.4, uniformflag=True, scalecenter="origin", freeze=True
    )
    return [closed, ms.get_geometric_measures(), ms.get_topological_measures()]


def measures_xmlfilter(ms: Any) -> Measures:
    return [ms.get_geometric_measures(), ms.get_topological_measures()]


def select_small_parts(ms: Any) -> Measures:
    ms.compute_selection_by_small_disconnected_components_per_face(nbfaceratio=0.1)
    ms.meshing_remove_selected_vertices_and_faces()
    return []


def cut_by_condition(ms: Any) -> Measures:
    ms.compute_selection_by_condition_per_vertex(condselect="(z < -0.5) && (x > 0)")
    ms.meshing_remove_selected_vertices()
    ms.compute_selection_by_condition_per_face(condselect="(z0 > 0.8) && (z1 > 0.8)")
    ms.apply_selection_inverse(invfaces=True, invverts=False)
    return []


def select_by_colour(ms: Any) -> Measures:
    ms.compute_color_transfer_vertex_to_face()
    ms.compute_selection_by_color_per_face(
        color=Color(200, 60, 60, 255), colorspace="RGB", inclusive=True,
        percentrh=0.4, percentgs=0.4, percentbv=0.4,
    )  # fmt: skip
    ms.apply_selection_by_same_connected_component()
    ms.compute_selection_transfer_face_to_vertex(inclusive=True)
    return []


def select_by_quality(ms: Any) -> Measures:
    ms.compute_scalar_by_function_per_vertex(q="x*x+y*y", normalize=False, map=False)
    ms.compute_selection_by_scalar_per_vertex(minq=0, maxq=0.25, inclusive=True)
    ms.generate_from_selected_faces(deleteoriginal=True)
    ms.set_mesh_name(newname="poles of the ball")
    return []


def select_facing_up(ms: Any) -> Measures:
    ms.compute_selection_by_angle_with_direction_per_face(
        anglelimit=75, usecamera=False, viewpoint=np.array([0.0, 0.0, 10.0])
    )
    measured = ms.get_area_and_perimeter_of_selection()
    ms.generate_polyline_from_selection_perimeter()
    return [measured]


def cloud_outliers(ms: Any) -> Measures:
    ms.compute_selection_point_cloud_outliers(propthreshold=0.8, knearest=32)
    ms.meshing_remove_selected_vertices()
    ms.compute_custom_radius_scalar_attribute_per_vertex(nbneighbors=16)
    return []


def lod_chain(ms: Any) -> Measures:
    ms.generate_copy_of_current_mesh()
    ms.set_mesh_name(newname="lod1")
    ms.meshing_decimation_quadric_edge_collapse(
        targetfacenum=640, preservenormal=True, preservetopology=True
    )
    ms.generate_copy_of_current_mesh()
    ms.set_mesh_name(newname="lod2")
    ms.meshing_decimation_quadric_edge_collapse(targetfacenum=0, targetperc=0.25)
    return []


def decimate_2012(ms: Any) -> Measures:
    ms.meshing_decimation_quadric_edge_collapse(
        targetfacenum=500, targetperc=0, qualitythr=0.5, preserveboundary=True, boundaryweight=1,
        preservenormal=True, preservetopology=False, optimalplacement=True, planarquadric=False,
        selected=False,
    )  # fmt: skip
    return []


def decimate_clustering(ms: Any) -> Measures:
    ms.meshing_decimation_clustering(threshold=PureValue(0.2))
    ms.apply_coord_laplacian_smoothing(stepsmoothnum=2, boundary=True, cotangentweight=False)
    return []


def remesh_isotropic(ms: Any) -> Measures:
    ms.meshing_isotropic_explicit_remeshing(
        iterations=3, adaptive=False, targetlen=PureValue(0.2), featuredeg=30,
        checksurfdist=True, maxsurfdist=PureValue(0.05), splitflag=True, collapseflag=True,
        swapflag=True, smoothflag=True, reprojectflag=True,
    )  # fmt: skip
    ms.meshing_edge_flip_by_planar_optimization(
        selection=False, pthreshold=1, planartype="delaunay", iterations=1
    )
    return []


def subdivide_polygons(ms: Any) -> Measures:
    ms.create_cube(size=2)
    ms.meshing_surface_subdivision_catmull_clark(iterations=2)
    ms.meshing_poly_to_tri()
    ms.compute_normal_per_vertex(weightmode="By Angle")
    return []


def resample_volume(ms: Any) -> Measures:
    ms.generate_resampled_uniform_mesh(
        cellsize=PureValue(0.15), offset=PureValue(0.1), mergeclosevert=True, discretize=False,
        multisample=True, absdist=False,
    )  # fmt: skip
    ms.meshing_decimation_edge_collapse_for_marching_cube_meshes()
    return []


def refine_where(ms: Any) -> Measures:
    ms.meshing_refine_by_function(
        condselect="(z0 > 0.5) && (z1 > 0.5)", x="(x0+x1)/2", y="(y0+y1)/2", z="(z0+z1)/2"
    )
    ms.meshing_cut_along_crease_edges(angledeg=90)
    ms.meshing_snap_mismatched_borders(edgedistratio=0.01, unifyvertices=True)
    return []


def smooth_all_ways(ms: Any) -> Measures:
    ms.apply_coord_laplacian_smoothing(stepsmoothnum=3, boundary=True, cotangentweight=True)
    ms.apply_coord_taubin_smoothing(lambda_=0.5, mu=-0.53, stepsmoothnum=10)
    ms.apply_coord_hc_laplacian_smoothing()
    ms.apply_coord_laplacian_smoothing_scale_dependent(stepsmoothnum=2, delta=PureValue(0.01))
    ms.apply_coord_two_steps_smoothing(stepsmoothnum=1, normalthr=60, stepnormalnum=5, stepfitnum=5)
    ms.apply_coord_laplacian_smoothing_surface_preserving(angledeg=0.5, iterations=1)
    return []


def smooth_depth(ms: Any) -> Measures:
    ms.apply_coord_random_displacement(
        updatenormals=True, displacement=PureValue(0.02), randomseed=7
    )
    ms.apply_coord_depth_smoothing(
        stepsmoothnum=3, viewpoint=np.array([0.0, 0.0, 1.0]), delta=PureValue(0.34641)
    )
    return []


def geometry_function(ms: Any) -> Measures:
    ms.compute_coord_by_function(x="x", y="y*1.5", z="z+0.1*sin(5*x)")
    ms.compute_normal_per_face()
    ms.apply_normal_normalization_per_face()
    ms.apply_normal_smoothing_per_face()
    ms.compute_normal_per_vertex()
    ms.apply_normal_normalization_per_vertex()
    return []


def fractal_relief(ms: Any) -> Measures:
    ms.apply_coord_fractal_displacement(
        maxheight=PureValue(0.1), scale=1, smoothingsteps=5, seed=2,
        algorithm="Ridged multifractal terrain", octaves=8,
    )  # fmt: skip
    return []


def colour_grading(ms: Any) -> Measures:
    ms.apply_color_brightness_contrast_gamma_per_vertex(brightness=20, contrast=10, gamma=1.2)
    ms.apply_color_level_adjustment_per_vertex(
        gamma=1, in_min=10, in_max=240, out_min=0, out_max=255, rch=True, gch=True, bch=False
    )
    ms.apply_color_white_balance_per_vertex(color=Color(240, 235, 210, 255))
    ms.apply_color_intensity_colourisation_per_vertex(
        hue=210, saturation=40, luminance=50, intensity=30
    )
    ms.apply_color_desaturation_per_vertex(method="Luminosity")
    ms.apply_color_inverse_per_vertex()
    ms.apply_color_equalization_per_vertex()
    ms.apply_color_laplacian_smoothing_per_vertex(iteration=2)
    return []


def colour_two_tone(ms: Any) -> Measures:
    ms.apply_color_thresholding_per_vertex(
        color1=Color(20, 20, 20, 255), color2=Color(250, 240, 200, 255), threshold=128
    )
    ms.compute_color_transfer_vertex_to_face()
    ms.apply_color_laplacian_smoothing_per_face(iteration=1)
    ms.compute_color_transfer_face_to_vertex()
    return []


def colour_filling(ms: Any) -> Measures:
    ms.set_color_per_vertex(color1=Color(180, 120, 40, 255))
    ms.compute_selection_by_condition_per_vertex(condselect="z > 0")
    ms.compute_color_perlin_noise_per_vertex(
        color1=Color(255, 255, 255, 255), color2=Color(90, 60, 20, 255), freq=8,
        offset=np.array([0.5, -0.25, 0.125]), onselected=True,
    )  # fmt: skip
    return []


def colour_functions(ms: Any) -> Measures:
    ms.set_color_per_vertex()
    ms.compute_color_by_function_per_vertex(
        x="127.5+127.5*x", y="y > 0 ? 255 : 40", z="127", a="255"
    )
    ms.compute_color_by_function_per_face(
        r="255*abs(fnx)", g="255*abs(fny)", b="255*abs(fnz)", a="255"
    )
    return []


def curvature_map(ms: Any) -> Measures:
    curved = ms.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Mean Curvature")
    ms.apply_scalar_smoothing_per_vertex()
    ms.apply_scalar_clamping_per_vertex(minval=0.9, maxval=1.1, perc=0, zerosym=False)
    statistics = ms.get_scalar_statistics_per_vertex()
    histogram = ms.get_scalar_histogram_per_vertex(
        histmin=0.9, histmax=1.1, areaweighted=False, binnum=4
    )
    ms.compute_color_from_scalar_per_vertex(
        minval=0.9, maxval=1.1, perc=0, zerosym=False, colormap="Viridis"
    )
    return [curved, statistics, histogram]


def principal_curvature(ms: Any) -> Measures:
    ms.compute_curvature_principal_directions_per_vertex(
        method="Quadric Fitting", curvcolormethod="Mean Curvature", scale=PureValue(0.1),
        autoclean=True,
    )  # fmt: skip
    return []


def geodesic_from_point(ms: Any) -> Measures:
    ms.compute_scalar_by_geodesic_distance_from_given_point_per_vertex(
        startpoint=np.array([0.0, 0.0, 1.0]), maxdistance=PureValue(100)
    )
    return [ms.get_scalar_statistics_per_vertex()]


def distance_from_border(ms: Any) -> Measures:
    ms.compute_scalar_by_border_distance_per_vertex()
    ms.compute_selection_by_scalar_per_vertex(minq=0, maxq=0.15, inclusive=True)
    ms.apply_scalar_smoothing_per_vertex()
    return []


def face_quality(ms: Any) -> Measures:
    ms.compute_scalar_by_aspect_ratio_per_face(metric="area/max side")
    statistics = ms.get_scalar_statistics_per_face()
    histogram = ms.get_scalar_histogram_per_face(histmin=0, histmax=1, binnum=5)
    ms.compute_selection_by_scalar_per_face(minq=0, maxq=0.8, inclusive=True)
    ms.compute_color_from_scalar_per_face()
    ms.compute_scalar_transfer_face_to_vertex(areaweight=True)
    ms.compute_scalar_transfer_vertex_to_face()
    return [statistics, histogram]


def harmonic_field(ms: Any) -> Measures:
    ms.compute_scalar_by_scalar_harmonic_field_per_vertex(
        point1=np.array([0.0, 0.0, 1.0]), point2=np.array([0.0, 0.0, -1.0]), value1=0, value2=1,
        colorize=True,
    )  # fmt: skip
    return []


def normals_for_cloud(ms: Any) -> Measures:
    ms.compute_normal_for_point_clouds(
        k=12, smoothiter=1, flipflag=True, viewpos=np.array([0.0, 0.0, 10.0])
    )
    ms.apply_normal_point_cloud_smoothing(k=8, usedist=False)
    ms.apply_normal_normalization_per_vertex()
    return []


def sample_regular(ms: Any) -> Measures:
    ms.generate_sampling_clustered_vertex(
        threshold=PureValue(0.3), sampling="Closest to center", selected=False
    )
    ms.set_current_mesh(0)
    ms.generate_sampling_regular_recursive(cellsize=PureValue(0.3), offset=PureValue(0))
    return []


def poisson_from_cloud(ms: Any) -> Measures:
    ms.compute_normal_for_point_clouds(k=10)
    ms.generate_surface_reconstruction_screened_poisson(
        depth=5, fulldepth=5, cgdepth=0, scale=1.1, samplespernode=1.5, pointweight=4, iters=8,
        threads=1,
    )  # fmt: skip
    return []


def ball_pivoting(ms: Any) -> Measures:
    ms.generate_surface_reconstruction_ball_pivoting(
        ballradius=PureValue(0.4), clustering=20, creasethr=90, deletefaces=False
    )
    return [ms.meshing_close_holes(maxholesize=30), ms.get_topological_measures()]


def bake_colours_2016(ms: Any) -> Measures:
    ms.compute_texcoord_parametrization_triangle_trivial_per_wedge(
        sidedim=0, textdim=256, border=2, method="Space-optimizing"
    )
    ms.compute_texmap_from_color(textname="baked.png", textw=256, texth=256, pullpush=True)
    return []


def texture_to_colours(ms: Any) -> Measures:
    ms.compute_color_from_texture_per_vertex()
    ms.compute_texcoord_transfer_wedge_to_vertex()
    ms.compute_texcoord_transfer_vertex_to_wedge()
    return []


def texture_to_another_2016(ms: Any) -> Measures:
    ms.transfer_texture_to_color_per_vertex(sourcemesh=0, targetmesh=1, upperbound=PureValue(0.2))
    return []


def flatten_layers(ms: Any) -> Measures:
    ms.generate_by_merging_visible_meshes(
        mergevisible=True, deletelayer=True, mergevertices=True, alsounreferenced=False
    )
    ms.generate_splitting_by_connected_components(delete_source_mesh=False)
    return []


def layers_by_position(ms: Any) -> Measures:
    ms.set_current_mesh(0)
    ms.delete_current_mesh()
    ms.generate_copy_of_current_mesh()
    ms.set_current_mesh(1)  # numbers stay with their layers, positions do not
    ms.set_mesh_name(newname="the one that stayed")
    return []


def move_to_origin_2013(ms: Any) -> Measures:
    ms.compute_matrix_from_translation(
        traslmethod="XYZ translation", axisx=1.5, axisy=0, axisz=-2, freeze=True
    )
    return []


def center_2013(ms: Any) -> Measures:
    ms.compute_matrix_from_translation(traslmethod="Center on Layer BBox", freeze=True)
    return []


def scale_2013(ms: Any) -> Measures:
    ms.compute_matrix_from_scaling_or_normalization(
        axisx=10, uniformflag=True, scalecenter="barycenter", unitflag=False, freeze=True,
        alllayers=True,
    )  # fmt: skip
    return []


def center_and_unit(ms: Any) -> Measures:
    ms.compute_matrix_from_translation(
        traslmethod="Center on Layer BBox", freeze=False, alllayers=True
    )
    ms.compute_matrix_from_scaling_or_normalization(unitflag=True, freeze=False)
    ms.apply_matrix_freeze(alllayers=True)
    return []


def turn_about_axis(ms: Any) -> Measures:
    ms.compute_matrix_from_rotation(
        rotaxis="custom axis", rotcenter="custom point", angle=33.3,
        customaxis=np.array([1.0, 1.0, 0.0]), customcenter=np.array([0.5, 0.0, 0.0]),
        freeze=False,
    )  # fmt: skip
    return []


def set_matrix(ms: Any) -> Measures:
    matrix = np.array([[0, -1, 0, 2.5], [1, 0, 0, 0], [0, 0, 1, -0.1], [0, 0, 0, 1.0]])
    ms.set_matrix(transformmatrix=matrix, compose=False, freeze=False)
    ms.apply_matrix_inverse(freeze=False)
    ms.generate_copy_of_current_mesh()
    ms.set_matrix_identity()
    return []


def flip_and_swap(ms: Any) -> Measures:
    ms.apply_matrix_flip_or_swap_axis(flipx=True, swapyz=True, freeze=True, alllayers=True)
    ms.compute_matrix_from_translation_rotation_scale(
        translationx=1, translationy=2, translationz=3, rotationx=90,
        scalex=2, scaley=2, scalez=2, compose=False, freeze=True,
    )  # fmt: skip
    return []


def compare_scans(ms: Any) -> Measures:
    distance = ms.get_hausdorff_distance(
        sampledmesh=0, targetmesh=1, savesample=False, samplevert=True, sampleedge=False,
        samplefauxedge=False, sampleface=False, samplenum=642, maxdist=PureValue(2),
    )  # fmt: skip
    ms.compute_scalar_by_distance_from_another_mesh_per_vertex(
        measuremesh=0, refmesh=1, signeddist=True, maxdist=PureValue(2)
    )
    ms.set_current_mesh(0)
    return [distance, ms.get_scalar_statistics_per_vertex()]


def boolean_all(ms: Any) -> Measures:
    ms.generate_boolean_union(first_mesh=0, second_mesh=1)
    union = ms.get_geometric_measures()
    ms.generate_boolean_intersection(first_mesh=0, second_mesh=1)
    common = ms.get_geometric_measures()
    ms.generate_boolean_difference(first_mesh=0, second_mesh=1)
    ms.generate_boolean_xor(first_mesh=0, second_mesh=1)
    return [union, common]


def boolean_2009(ms: Any) -> Measures:
    ms.generate_boolean_intersection(first_mesh=1, second_mesh=0)
    return []


def quality_mapper_2011(ms: Any) -> Measures:
    ms.compute_scalar_by_function_per_vertex(q="z")
    ms.compute_color_from_scalar_using_transfer_function_per_vertex(
        minqualityval=-1, maxqualityval=1, midhandlepos=50, brightness=1, tfslist="RGB"
    )
    return []


def transfer_colours(ms: Any) -> Measures:
    ms.transfer_attributes_per_vertex(
        sourcemesh=0, targetmesh=1, geomtransfer=False, normaltransfer=False, colortransfer=True,
        qualitytransfer=True, selectiontransfer=False, qualitydistance=False,
        upperbound=PureValue(1), onselected=False,
    )  # fmt: skip
    return []


def paint_by_points(ms: Any) -> Measures:
    ms.compute_color_by_point_cloud_voronoi_projection(coloredmesh=0, vertexmesh=1, backward=False)
    ms.compute_scalar_by_distance_from_point_cloud_per_vertex(
        coloredmesh=0, vertexmesh=1, radius=0.3, sampleradius=False, approximategeodetic=False
    )
    return []


def morph(ms: Any) -> Measures:
    ms.set_current_mesh(0)
    ms.compute_coord_linear_morphing(targetmesh=1, percentmorph=50)
    return []


def slice(ms: Any) -> Measures:
    ms.generate_polyline_from_planar_section(
        planeaxis="Z Axis", planeoffset=0.25, relativeto="Origin", createsectionsurface=True,
        splitsurfacewithsection=False,
    )  # fmt: skip
    return []


def slice_2015(ms: Any) -> Measures:
    ms.generate_polyline_from_planar_section(
        planeaxis="Custom Axis", customaxis=np.array([0.0, 1.0, 1.0]), planeoffset=0.1,
        relativeto="Bounding box center",
    )  # fmt: skip
    return []


def crease_lines(ms: Any) -> Measures:
    ms.compute_selection_crease_per_edge(angledegneg=-45, angledegpos=45)
    ms.generate_polyline_from_selected_edges()
    return []


def custom_attributes(ms: Any) -> Measures:
    ms.compute_new_custom_scalar_attribute_per_vertex(name="height", expr="z+1")
    ms.compute_new_custom_scalar_attribute_per_face(name="slope", expr="fnz")
    ms.compute_scalar_by_function_per_vertex(q="height*2")
    return []


def python_names(ms: Any) -> Measures:
    ms.meshing_merge_close_vertices()
    ms.apply_coord_taubin_smoothing(lambda_=0.33, mu=-0.34, stepsmoothnum=4)
    return [ms.get_topological_measures()]


def untyped(ms: Any) -> Measures:
    ms.apply_coord_laplacian_smoothing(stepsmoothnum=2, boundary=True, cotangentweight=False)
    ms.set_color_per_vertex(color1=Color(10, 20, 30, 255))
    return []


def blanks_and_cases(ms: Any) -> Measures:
    ms.meshing_remove_duplicate_vertices()
    ms.apply_coord_taubin_smoothing(lambda_=0.4, mu=-0.41, stepsmoothnum=3, selected=False)
    return []


def enum_by_word(ms: Any) -> Measures:
    ms.meshing_repair_non_manifold_edges(method="Split Vertices")
    curved = ms.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Gaussian Curvature")
    return [curved, ms.get_scalar_statistics_per_vertex()]


def percentages(ms: Any) -> Measures:
    ms.meshing_merge_close_vertices(threshold=PureValue(0.000346))
    ms.meshing_decimation_clustering(threshold=PercentageValue(5))
    return []


def latin1(ms: Any) -> Measures:
    ms.set_mesh_name(newname="Büste aus Köln")
    ms.apply_coord_laplacian_smoothing(stepsmoothnum=1)
    return []


def nothing_to_do(ms: Any) -> Measures:
    return []


BY_HAND: dict[str, Callable[[Any], Measures]] = {
    function.__name__: function
    for function in (
        clean_scan, clean_scan_2014, clean_by_diameter, print_preparation, measures_xmlfilter,
        select_small_parts, cut_by_condition, select_by_colour, select_by_quality,
        select_facing_up, cloud_outliers, lod_chain, decimate_2012, decimate_clustering,
        remesh_isotropic, subdivide_polygons, resample_volume, refine_where, smooth_all_ways,
        smooth_depth, geometry_function, fractal_relief, colour_grading, colour_two_tone,
        colour_filling, colour_functions, curvature_map, principal_curvature,
        geodesic_from_point, distance_from_border, face_quality, harmonic_field,
        normals_for_cloud, sample_regular, poisson_from_cloud, ball_pivoting,
        bake_colours_2016, texture_to_colours, texture_to_another_2016, flatten_layers,
        layers_by_position, move_to_origin_2013, center_2013, scale_2013, center_and_unit,
        turn_about_axis, set_matrix, flip_and_swap, compare_scans, boolean_all,
        transfer_colours, paint_by_points, morph, slice, slice_2015, crease_lines,
        custom_attributes, python_names, untyped, blanks_and_cases, enum_by_word, percentages,
        latin1, nothing_to_do, boolean_2009, quality_mapper_2011,
    )
}  # fmt: skip

# The same with the methods that load_plugins gives to every MeshSet.


def statue_by_alias(ms: Any) -> None:
    ms.generate_simplified_points(count=300)
    ms.power_crust_reconstruct(surface="interpolating", smallestball=0.0)
    ms.get_geometric_measures()


def statue_from_scan(ms: Any) -> None:
    ms.compute_normal_for_point_clouds()
    ms.detect_reflection_planes()
    ms.mirror_complete_points(gap=1.5)
    ms.generate_surface_reconstruction_power_crust(paint=True)
    ms.apply_coord_laplacian_smoothing(stepsmoothnum=1)
    ms.get_topological_measures()


def select_and_detect(ms: Any) -> None:
    ms.compute_normal_for_point_clouds()
    ms.compute_selection_by_condition_per_vertex(condselect="z > -0.6")
    ms.generate_reflection_planes(maxplanes=1, onlyselected=True)
    ms.set_selection_none()
    ms.generate_mirror_completed_points()
    ms.set_mesh_name(newname="whole statue")


def deviation_in_colours(ms: Any) -> None:
    ms.compute_normal_for_point_clouds()
    ms.generate_reflection_planes(maxplanes=1)
    ms.mirror_symmetry_deviation(planes=1, plane=0)
    ms.compute_color_from_scalar_per_vertex(zerosym=True, perc=2)


WITH_PLUGINS: dict[str, Callable[[Any], None]] = {
    function.__name__: function
    for function in (statue_by_alias, statue_from_scan, select_and_detect, deviation_in_colours)
}

# MeshLab numbers the cells of a clustering, and cuts plane faces of a boolean into triangles, in
# an order that changes from run to run.
SAME_SHAPE = ("decimate_clustering", "percentages", "boolean_all", "boolean_2009")
ROUNDING = 1e-12


def same_shape(got: list[dict[str, Any]], wanted: list[dict[str, Any]]) -> None:
    """Check that two documents have the same points and the same surface, in whatever order."""
    assert [layer["label"] for layer in got] == [layer["label"] for layer in wanted]
    for one, other in zip(got, wanted, strict=True):
        assert one["faces"].shape == other["faces"].shape
        np.testing.assert_allclose(_sorted_points(one), _sorted_points(other), 0.0, ROUNDING)
        np.testing.assert_allclose(_area_and_volume(one), _area_and_volume(other), ROUNDING)


def _sorted_points(layer: dict[str, Any]) -> np.ndarray:
    points = layer["vertices"]
    return points[np.lexsort(np.round(points, 9).T)]


def _area_and_volume(layer: dict[str, Any]) -> tuple[float, float]:
    first, second, third = np.moveaxis(layer["vertices"][layer["faces"]], 1, 0)
    normals = np.cross(second - first, third - first)
    volume = np.einsum("ij,ij->", first, np.cross(second, third)) / 6.0
    return np.linalg.norm(normals, axis=1).sum() / 2.0, volume
