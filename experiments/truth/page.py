def page(document, scenes):
    return ""
