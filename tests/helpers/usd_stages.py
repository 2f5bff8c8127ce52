"""Texts of USD stages, and a way to load them."""

import pytest

import photonmap as pm

TRIANGLE = """def Mesh "{name}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    uniform token subdivisionScheme = "none"
    {more}
}}
"""


def triangle(more="", name="part"):
    return TRIANGLE.format(name=name, more=more)


def surface(inputs, name="paint", more=""):
    return f"""def Material "{name}" {{
        token outputs:surface.connect = </{name}/shader.outputs:surface>
        def Shader "shader" {{
            uniform token info:id = "UsdPreviewSurface"
            {inputs}
            token outputs:surface
        }}
        {more}
    }}
    """


def painted(inputs, more=""):
    return surface(inputs, more=more) + triangle("rel material:binding = </paint>")


def light(kind, more, apis=""):
    apis = f"({apis})" if apis else ""
    return f'def {kind} "lamp" {apis} {{\n{more}\n}}\n' + triangle()


READER = """
        def Shader "reader" {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }"""


def load_stage(folder, inside, head="", name="a.usda"):
    """Write a stage and load it."""
    pytest.importorskip("pxr", reason="needs usd-core: pip install 'photonmap[usd]'")
    (folder / name).write_text(f"#usda 1.0\n({head})\n{inside}")
    return pm.load_scene(folder / name)
